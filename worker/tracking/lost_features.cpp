#include "worker/tracking/lost_features.hpp"

#include <algorithm>

namespace divemesh::worker {
namespace {

constexpr int kLongest_frames = 5;
constexpr double kLeastCorrelation = 0.85;
constexpr double kTolerance_px = 2.0;
constexpr double kNearest_m = 0.05;

}  // namespace

void LostFeatures::lose(const Feature& feature, const FirstLook& look) {
    lost_.push_back({feature.id, point_cam(rig_, feature), 0, look});
}

std::vector<LostFeatures::Found> LostFeatures::find(const cv::Mat& picture,
                                                    const Eigen::Isometry3d& T_current_previous) {
    std::vector<Found> found;
    std::erase_if(lost_, [&](Lost& lost) {
        lost.p_cam = T_current_previous * lost.p_cam;
        lost.look.move(T_current_previous);
        if (lost.p_cam.z() < kNearest_m || ++lost.num_frames > kLongest_frames) return true;
        const Eigen::Vector3d expected = project_px(rig_, lost.p_cam);
        const auto look = lost.look.from_here(rig_, Eigen::Isometry3d::Identity());
        const auto there = look ? look->align(picture, expected.head<2>()) : std::nullopt;
        if (!there || there->correlation < kLeastCorrelation ||
            (there->pixel - expected.head<2>()).norm() > kTolerance_px)
            return false;
        found.push_back({{lost.id, there->pixel, expected.z()}, lost.look});
        return true;
    });
    std::sort(found.begin(), found.end(), [](const Found& a, const Found& b) {
        return a.feature.id < b.feature.id;
    });
    return found;
}

}  // namespace divemesh::worker
