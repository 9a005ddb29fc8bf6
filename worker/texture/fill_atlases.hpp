#pragma once

#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <vector>

#include "worker/texture/level_seams.hpp"
#include "worker/texture/pack_cutouts.hpp"

namespace divemesh::texture {

// What the atlases are filled from.
struct AtlasSources {
    const types::Mesh& mesh;
    const FaceViews& views;
    const Photographs& photographs;
    const SeamColors& seam_colors;
    const Levelling& levelling;
    const Cutouts& cutouts;
};

// The pixels of the atlases.
struct FilledAtlases {
    std::vector<cv::Mat> images;          // CV_8UC3
    std::vector<std::uint8_t> is_filled;  // of each cutout; 0: no room, or its image not readable
};

// Reads each keyframe's image once and writes its cutouts, levelled, to their places.
FilledAtlases fill_atlases(const AtlasSources& sources,
                           const AtlasPlan& plan,
                           int num_threads,
                           const base::ProgressShare& progress);

}  // namespace divemesh::texture
