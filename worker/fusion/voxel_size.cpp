#include "worker/fusion/voxel_size.hpp"

#include <algorithm>
#include <cmath>

namespace divemesh::fusion {
namespace {

constexpr double kSigmaDisparity_px = 0.15;  // of a textured surface
constexpr double kPixelsPerVoxel = 2.5;
constexpr double kFarSigmaShare = 0.5;       // of the depth's standard deviation, in a voxel
constexpr double kMaxRelativeSigma = 0.017;  // of a depth that may make surface, of the depth

double sigma_z(const types::RectifiedRig& rig, double depth_m) {
    return depth_m * depth_m * kSigmaDisparity_px / (rig.focal_px * rig.baseline_m);
}

double pixels_m(const types::RectifiedRig& rig, double depth_m) {
    return kPixelsPerVoxel * depth_m / rig.focal_px;
}

// Returns the edge of voxels that suit surface at a depth beside that of the median depth, m.
double detail_m(const types::RectifiedRig& rig, double depth_m) {
    return std::max(pixels_m(rig, depth_m), kFarSigmaShare * sigma_z(rig, depth_m));
}

// Returns the depth at which detail_m() is `voxel_m`.
double depth_of_detail_m(const types::RectifiedRig& rig, double voxel_m) {
    return std::min(voxel_m / pixels_m(rig, 1.0),
                    std::sqrt(voxel_m / (kFarSigmaShare * sigma_z(rig, 1.0))));
}

double usual_depth_m(double median_depth_m) { return std::clamp(median_depth_m, 0.2, 50.0); }

}  // namespace

double choose_voxel_m(const types::RectifiedRig& rig, double median_depth_m) {
    const double depth = usual_depth_m(median_depth_m);
    const double voxel = std::max(pixels_m(rig, depth), sigma_z(rig, depth));
    return std::max(0.001, std::round(voxel * 1000.0) / 1000.0);
}

double choose_max_depth_m(const types::RectifiedRig& rig, double voxel_m) {
    return std::sqrt(kMaxSigma_voxels * voxel_m / sigma_z(rig, 1.0));
}

double farthest_surface_m(const types::RectifiedRig& rig, double median_depth_m) {
    const double max_sigma_m =
        kMaxSigma_voxels *
        tolerated_voxel_m(rig, choose_voxel_m(rig, median_depth_m), kMaxRelativeLevel);
    return std::sqrt(max_sigma_m * rig.focal_px * rig.baseline_m / kMinDisparitySigma_px);
}

double tolerated_voxel_m(const types::RectifiedRig& rig, double median_voxel_m, int num_coarser) {
    if (num_coarser <= 0) return median_voxel_m;
    const double depth_m = depth_of_detail_m(rig, std::ldexp(median_voxel_m, num_coarser));
    return std::max(median_voxel_m * std::exp2(0.25 * num_coarser),
                    kMaxRelativeSigma * depth_m / kMaxSigma_voxels);
}

int relative_level(const types::RectifiedRig& rig, double median_depth_m, double depth_m) {
    const double ratio = detail_m(rig, depth_m) / detail_m(rig, usual_depth_m(median_depth_m));
    return std::clamp(
        static_cast<int>(std::lround(std::log2(ratio))), kMinRelativeLevel, kMaxRelativeLevel);
}

}  // namespace divemesh::fusion
