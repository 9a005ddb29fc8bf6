#include <gtest/gtest.h>

#include "tests/synthetic/sea_floor.hpp"
#include "worker/features/track_features.hpp"

namespace divemesh::features {
namespace {

using synthetic::SeaFloor;

cv::Mat look_from(const Eigen::Isometry3d& T_world_cam) {
    cv::Mat gray;
    cv::extractChannel(SeaFloor().look(T_world_cam).left_color, gray, 0);
    return gray;
}

// Two images of a floor: half of the first is out of the second, and the camera turned in plane.
struct WideStep {
    WideStep() {
        T_world_to.translation() << 1.1, 0.2, 0.15;
        T_world_to.rotate(Eigen::AngleAxisd(0.5, Eigen::Vector3d::UnitZ()));
        tracker.track(look_from(T_world_from), {}, Eigen::Isometry3d::Identity());
        before = tracker.detect({});
        for (types::Feature& feature : before)
            feature.disparity_px = rig.disparity_px(
                SeaFloor::seen_at(T_world_from, feature.pixel.x(), feature.pixel.y()).z());
    }
    Eigen::Isometry3d motion() const { return T_world_to.inverse() * T_world_from; }
    Eigen::Vector2d truth(const types::Feature& feature) const {
        return rig.pixel(motion() * types::point_cam(rig, feature));
    }
    std::size_t num_in_sight() const {
        return static_cast<std::size_t>(
            std::count_if(before.begin(), before.end(), [&](const types::Feature& feature) {
                const Eigen::Vector2d pixel = truth(feature);
                return pixel.minCoeff() > 12.0 && pixel.x() < rig.width_px - 12.0 &&
                       pixel.y() < rig.height_px - 12.0;
            }));
    }
    // Returns the tracks within a third of a pixel of the truth.
    std::size_t num_right(const types::Features& tracks) const {
        return static_cast<std::size_t>(
            std::count_if(tracks.begin(), tracks.end(), [&](const types::Feature& track) {
                const auto from =
                    std::find_if(before.begin(), before.end(), [&](const types::Feature& feature) {
                        return feature.id == track.id;
                    });
                return from != before.end() && (truth(*from) - track.pixel).norm() < 0.33;
            }));
    }

    types::RectifiedRig rig = synthetic::small_rig();
    Eigen::Isometry3d T_world_from = Eigen::Isometry3d::Identity();
    Eigen::Isometry3d T_world_to = Eigen::Isometry3d::Identity();
    FeatureTracker tracker{rig, 200};
    types::Features before;
};

TEST(TrackAgainTest, FollowsTurnedFeaturesFromAMotionThatIsTwoPixelsOff) {
    WideStep step;
    const types::Features lost =
        step.tracker.track(look_from(step.T_world_to), step.before, Eigen::Isometry3d::Identity());
    EXPECT_LT(step.num_right(lost), 5U);

    Eigen::Isometry3d guess = step.motion();
    guess.translation().x() += 0.016;
    const types::Features tracks = step.tracker.track_again(step.before, guess);

    ASSERT_GT(step.num_in_sight(), 40U);
    EXPECT_GT(tracks.size(), step.num_in_sight() * 7 / 10);
    EXPECT_GT(step.num_right(tracks), tracks.size() * 9 / 10);
}

TEST(TrackAgainTest, ReferencePatchesLiveOnAfterTheFirstAttempt) {
    WideStep step;
    const cv::Mat to = look_from(step.T_world_to);
    step.tracker.track(to, step.before, Eigen::Isometry3d::Identity());
    types::Features tracks = step.tracker.track_again(step.before, step.motion());
    const types::Features stay = step.tracker.track(to, tracks, Eigen::Isometry3d::Identity());
    EXPECT_GT(stay.size(), tracks.size() * 9 / 10);
    EXPECT_GT(step.num_right(stay), stay.size() * 9 / 10);
}

}  // namespace
}  // namespace divemesh::features
