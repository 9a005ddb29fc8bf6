#include "worker/pipeline/window_tracker.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>

#include "tests/synthetic/sea_floor.hpp"
#include "tests/synthetic/sensor_recording.hpp"
#include "worker/base/seconds.hpp"
#include "worker/stats/median.hpp"

namespace divemesh::pipeline {
namespace {

using synthetic::SeaFloor;

constexpr double kPeriod_s = 0.1;
constexpr int kNumFrames = 14;
constexpr int kNumTogether = 4;  // pairs at the start, until the velocity is known

// A rig that glides over the floor at a known velocity. Its right camera is exposed up to 40 ms
// before or after the left one, at another time in each pair.
class UnevenPairsTest : public testing::Test {
protected:
    static Eigen::Isometry3d T_world_cam(double time_s) {
        Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
        T.translate(time_s * Eigen::Vector3d(0.25, 0.1, 0.0));
        T.rotate(Eigen::AngleAxisd(0.4, Eigen::Vector3d::UnitX()));
        return T;
    }
    static double gap_s(int index) { return index < kNumTogether ? 0.0 : 0.02 * (index % 5 - 2); }
    static cv::Mat look(const Eigen::Isometry3d& T_world_cam) {
        cv::Mat gray;
        cv::extractChannel(SeaFloor().look(T_world_cam).left_color, gray, 0);
        return gray;
    }
    types::RectifiedFrame frame(int index) const {
        const double time_s = index * kPeriod_s;
        types::RectifiedFrame frame;
        frame.index = index;
        frame.timestamp_ns = base::to_ns(1.0 + time_s);
        frame.left = look(T_world_cam(time_s));
        frame.right = look(T_world_cam(time_s + gap_s(index)) *
                           Eigen::Translation3d(rig_.baseline_m, 0.0, 0.0));
        return frame;
    }

    // Returns the median error of the motion between frames, with or without knowledge of the gaps.
    double motion_error_m(bool gaps_are_known) const {
        const synthetic::SensorRecording recording;
        WindowTracker tracker(rig_, recording, options_, {});
        const Eigen::Isometry3d T_current_previous =
            T_world_cam(kPeriod_s).inverse() * T_world_cam(0.0);
        std::vector<double> errors_m;
        for (int i = 0; i < kNumFrames; ++i) {
            types::RectifiedFrame recorded = frame(i);
            if (gaps_are_known) recorded.right_delay_s = gap_s(i);
            const TrackedFrame tracked = tracker.process(recorded);
            if (i >= kNumTogether)
                errors_m.push_back(
                    (tracked.T_current_previous.translation() - T_current_previous.translation())
                        .norm());
        }
        return stats::median(std::move(errors_m));
    }

    const types::RectifiedRig rig_ = synthetic::small_rig();
    const ReconstructionOptions options_ =
        make_options("standard", {{"surface", false}, {"use_imu", false}, {"use_ahrs", false}});
};

TEST_F(UnevenPairsTest, TheMotionDuringTheGapOfEachPairIsTakenOff) {
    const double compensated_m = motion_error_m(true);

    EXPECT_LT(compensated_m, 0.002);
    EXPECT_LT(compensated_m, 0.5 * motion_error_m(false));
}

struct ShortRecording : synthetic::SensorRecording {
    int num_frames() const override { return kNumTogether; }
};

// Without a second keyframe the path would have no covariance.
TEST_F(UnevenPairsTest, ADiveTooShortForASecondKeyframeEndsWithOne) {
    const auto keyframes_of = [&](const types::Recording& recording) {
        WindowTracker tracker(rig_, recording, options_, {});
        for (int i = 0; i < kNumTogether; ++i) tracker.process(frame(i));
        types::Track track;
        tracker.move_to(track);
        return track.keyframes;
    };
    ASSERT_EQ(keyframes_of(synthetic::SensorRecording()).size(), 1U);
    const auto keyframes = keyframes_of(ShortRecording());
    ASSERT_EQ(keyframes.size(), 2U);
    EXPECT_EQ(keyframes[1].frame_index, kNumTogether - 1);
}

}  // namespace
}  // namespace divemesh::pipeline
