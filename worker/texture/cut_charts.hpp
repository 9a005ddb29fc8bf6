#pragma once

#include <cstdint>
#include <opencv2/core/types.hpp>
#include <vector>

#include "worker/texture/face_views.hpp"
#include "worker/texture/photographs.hpp"
#include "worker/texture/shared_edges.hpp"

namespace divemesh::texture {

// A rectangle of a keyframe's image with the charts that are cut out of it. A chart is a connected
// part of the surface that takes its colour from one keyframe. Charts whose rectangles overlap
// share a cutout where that saves texels.
struct Cutout {
    std::int32_t keyframe = 0;
    cv::Rect pixels;  // what the charts cover, without a border
};

// The cutouts of a mesh.
struct Cutouts {
    static constexpr std::int32_t kNone = -1;

    std::vector<Cutout> all;  // in the order of their keyframes
    std::vector<std::int32_t> of_triangle;
};

// Cuts the mesh into charts. Every triangle that has a view must be in front of its camera.
Cutouts cut_charts(const types::Mesh& mesh,
                   const FaceViews& views,
                   const std::vector<SharedEdge>& edges,
                   const Photographs& photographs);

}  // namespace divemesh::texture
