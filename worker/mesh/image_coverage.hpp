#pragma once

#include <cstdint>
#include <vector>

#include "worker/types/keyframe.hpp"
#include "worker/types/mesh.hpp"
#include "worker/types/rectified_rig.hpp"

namespace divemesh::mesh {

// How much of a keyframe's image the surface fills when seen from there.
struct ImageCoverage {
    std::int64_t timestamp_ns = 0;
    double covered_share = 0.0;
};

// Returns the coverage of keyframes spread over the dive, at most `max_images`, on a grid of pixels
// that is coarser than the images.
std::vector<ImageCoverage> image_coverage(const types::Mesh& mesh,
                                          const types::RectifiedRig& rig,
                                          const std::vector<types::Keyframe>& keyframes,
                                          int max_images);

// Returns the mean share; 0 where there is no image.
double mean_covered_share(const std::vector<ImageCoverage>& images);

}  // namespace divemesh::mesh
