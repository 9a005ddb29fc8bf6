#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <opencv2/core/matx.hpp>
#include <vector>

#include "worker/texture/face_views.hpp"
#include "worker/texture/photographs.hpp"
#include "worker/texture/shared_edges.hpp"

namespace divemesh::texture {

// An edge between two triangles that take their colours from different keyframes.
struct Seam {
    SharedEdge edge;
    std::array<std::int32_t, 2> keyframes = {};                  // of the triangles
    std::array<std::array<Eigen::Vector2f, 2>, 2> ends_px = {};  // of each side: both vertices
    std::size_t first_sample = 0;
    std::uint32_t num_samples = 0;

    // Returns where a sample lies on the edge, 0 to 1 from the first vertex.
    float along(std::uint32_t sample) const {
        return (static_cast<float>(sample) + 0.5F) / static_cast<float>(num_samples);
    }
    // Returns where the image of a side shows a point of the edge.
    Eigen::Vector2f pixel(std::size_t side, float along) const {
        return (1.0F - along) * ends_px[side][0] + along * ends_px[side][1];
    }
};

// Two colours of 255 that differ by more do not show the same surface, or one that is displaced,
// and are not levelled.
inline constexpr double kMaxStep = 80.0;

// One of the two sides of a seam.
struct SeamSide {
    std::uint32_t seam = 0;
    std::uint32_t side = 0;
};

// The colours of both images along the seams, about a sample per pixel.
struct SeamColors {
    std::vector<Seam> seams;
    std::array<std::vector<cv::Vec3b>, 2> samples;  // of both sides, seam after seam

    Eigen::Vector3f color(const Seam& seam, std::size_t side, std::uint32_t sample) const {
        const cv::Vec3b& bgr = samples[side][seam.first_sample + sample];
        return {static_cast<float>(bgr[0]), static_cast<float>(bgr[1]), static_cast<float>(bgr[2])};
    }
};

// Reads each keyframe's image once and samples it along its seams. Where an image cannot be read,
// its triangles get kNoView in `views`, and its seams are left out.
SeamColors sample_seams(const types::Mesh& mesh,
                        const std::vector<SharedEdge>& edges,
                        const Photographs& photographs,
                        int num_threads,
                        const base::ProgressShare& progress,
                        FaceViews& views);

}  // namespace divemesh::texture
