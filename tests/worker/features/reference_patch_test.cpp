#include "worker/features/reference_patch.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "tests/synthetic/sea_floor.hpp"
#include "worker/features/track_features.hpp"
#include "worker/stats/median.hpp"

namespace divemesh::features {
namespace {

using synthetic::SeaFloor;

// Returns a pose that moves down to the floor and rotates about the line of sight.
Eigen::Isometry3d T_world_cam(int frame) {
    Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
    T.translation() << 0.005 * frame, 0.0, 0.02 * frame;
    T.rotate(Eigen::AngleAxisd(0.02 * frame, Eigen::Vector3d::UnitZ()));
    return T;
}

cv::Mat look(const SeaFloor& floor, int frame) {
    cv::Mat left;
    cv::extractChannel(floor.look(T_world_cam(frame)).left_color, left, 0);
    return left;
}

void measure(int frame, types::Features& features) {
    for (types::Feature& feature : features)
        feature.disparity_px = synthetic::small_rig().disparity_px(
            SeaFloor::seen_at(T_world_cam(frame), feature.pixel.x(), feature.pixel.y()).z());
}

TEST(ReferencePatchTest, AFeatureStaysInItsPlaceWhileTheCameraTurnsAndComesNearer) {
    constexpr int kNumFrames = 20;
    const types::RectifiedRig rig = synthetic::small_rig();
    const SeaFloor floor;
    FeatureTracker tracker(rig, 300);
    tracker.track(look(floor, 0), {}, Eigen::Isometry3d::Identity());
    types::Features features = tracker.detect({});
    measure(0, features);
    std::map<std::int64_t, Eigen::Vector3d> p_world;
    for (const types::Feature& feature : features)
        p_world[feature.id] = T_world_cam(0) * types::point_cam(rig, feature);
    const std::size_t num_first = features.size();
    for (int k = 1; k <= kNumFrames; ++k) {
        features =
            tracker.track(look(floor, k), features, T_world_cam(k).inverse() * T_world_cam(k - 1));
        measure(k, features);
    }
    EXPECT_GE(features.size(), num_first / 3);  // the others have left the image
    std::vector<double> errors_px;
    for (const types::Feature& feature : features)
        errors_px.push_back(
            (rig.pixel(T_world_cam(kNumFrames).inverse() * p_world[feature.id]) - feature.pixel)
                .norm());
    EXPECT_LT(stats::upper_median(errors_px), 0.15);
}

}  // namespace
}  // namespace divemesh::features
