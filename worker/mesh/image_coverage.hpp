#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "worker/types/keyframe.hpp"
#include "worker/types/mesh.hpp"
#include "worker/types/rectified_rig.hpp"

namespace divemesh::mesh {

// How much of a keyframe's image the surface fills when seen from there; shares are of its pixels.
struct ImageCoverage {
    std::int64_t timestamp_ns = 0;
    double covered_share = 0.0;          // by surface at any depth
    double matched_share = 0.0;          // with depth
    double covered_matched_share = 0.0;  // with depth, and surface at that depth
};

struct CoverageSettings {
    int max_images = 50;
    // Surface is at the depth of a pixel within three standard deviations of the depth and two
    // voxels of its range: those of fusion, between the finest and the coarsest.
    double finest_voxel_m = 0.0;
    double coarsest_voxel_m = 0.0;
    double max_depth_m = 0.0;  // farther surface was not wanted, so its depth is unknown; 0: all is
    double mesh_error_m = 0.0;  // by which simplification moved the surface; added
};

// Returns the depth of a keyframe; empty: unknown.
using DepthOfFrame = std::function<types::DepthMap(int frame_index)>;

// Returns the coverage of keyframes spread over the dive, on a grid of pixels that is coarser than
// the images. Runs of triangles that a keyframe cannot see are skipped.
std::vector<ImageCoverage> image_coverage(const types::Mesh& mesh,
                                          const types::RectifiedRig& rig,
                                          const std::vector<types::Keyframe>& keyframes,
                                          const DepthOfFrame& depth_of_frame,
                                          const CoverageSettings& settings);

// Returns the mean share; 0 where there is no image.
double mean_covered_share(const std::vector<ImageCoverage>& images);

// Returns the share of all depth in the images that the surface agrees with; nullopt without any.
std::optional<double> covered_share_of_matched(const std::vector<ImageCoverage>& images);

}  // namespace divemesh::mesh
