#include "worker/features/lost_features.hpp"

#include <algorithm>

namespace divemesh::features {
namespace {

constexpr int kMaxLostFrames = 5;
constexpr double kMinCorrelation = 0.85;
constexpr double kTolerance_px = 2.0;
constexpr double kMinDepth_m = 0.05;

}  // namespace

void LostFeatures::lose(const types::Feature& feature, const ReferencePatch& reference) {
    lost_.push_back({feature.id, types::point_cam(rig_, feature), 0, reference});
}

void LostFeatures::forget_newest() {
    std::erase_if(lost_, [](const Lost& lost) { return lost.num_frames == 0; });
}

std::vector<LostFeatures::Found> LostFeatures::find(const cv::Mat& image,
                                                    const Eigen::Isometry3d& T_current_previous) {
    std::vector<Found> found;
    std::erase_if(lost_, [&](Lost& lost) {
        lost.p_cam = T_current_previous * lost.p_cam;
        lost.reference.move(T_current_previous);
        if (lost.p_cam.z() < kMinDepth_m || ++lost.num_frames > kMaxLostFrames) return true;
        const Eigen::Vector3d expected = types::project_px(rig_, lost.p_cam);
        const auto patch = lost.reference.warp_to_current(rig_, Eigen::Isometry3d::Identity());
        const auto there = patch ? patch->align(image, expected.head<2>()) : std::nullopt;
        if (!there || there->correlation < kMinCorrelation ||
            (there->pixel - expected.head<2>()).norm() > kTolerance_px)
            return false;
        found.push_back({{lost.id, there->pixel, expected.z()}, lost.reference});
        return true;
    });
    std::sort(found.begin(), found.end(), [](const Found& a, const Found& b) {
        return a.feature.id < b.feature.id;
    });
    return found;
}

}  // namespace divemesh::features
