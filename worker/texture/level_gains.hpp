#pragma once

#include <Eigen/Core>
#include <vector>

#include "worker/texture/seam_colors.hpp"

namespace divemesh::texture {

// Returns for each keyframe the gain (b g r) after which images agree along most of their seams
// (Brown and Lowe, "Automatic panoramic image stitching using invariant features", 2007, here over
// logarithms). The mean logarithm is 0 over the keyframes, so that the picture as a whole keeps its
// brightness; a keyframe without seams has gain 1.
std::vector<Eigen::Vector3f> level_gains(const SeamColors& colors, std::size_t num_keyframes);

}  // namespace divemesh::texture
