#include "worker/fusion/voxel_size.hpp"

#include <algorithm>
#include <cmath>

namespace divemesh::fusion {
namespace {

constexpr double kSigmaDisparity_px = 0.15;  // of a textured surface
constexpr double kPixelsPerVoxel = 2.5;

double sigma_z(const types::RectifiedRig& rig, double depth_m) {
    return depth_m * depth_m * kSigmaDisparity_px / (rig.focal_px * rig.baseline_m);
}

double pixels_m(const types::RectifiedRig& rig, double depth_m) {
    return kPixelsPerVoxel * depth_m / rig.focal_px;
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
    const double max_sigma_m = kMaxSigma_voxels * tolerated_voxels(kMaxRelativeLevel) *
                               choose_voxel_m(rig, median_depth_m);
    return std::sqrt(max_sigma_m * rig.focal_px * rig.baseline_m / kMinDisparitySigma_px);
}

double tolerated_voxels(int num_coarser) { return std::exp2(0.25 * std::max(0, num_coarser)); }

int relative_level(const types::RectifiedRig& rig, double median_depth_m, double depth_m) {
    const auto detail_m = [&](double depth) {
        return std::max(pixels_m(rig, depth), 0.5 * sigma_z(rig, depth));
    };
    const double ratio = detail_m(depth_m) / detail_m(usual_depth_m(median_depth_m));
    return std::clamp(
        static_cast<int>(std::lround(std::log2(ratio))), kMinRelativeLevel, kMaxRelativeLevel);
}

}  // namespace divemesh::fusion
