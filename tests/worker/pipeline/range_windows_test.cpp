#include "worker/pipeline/range_windows.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <opencv2/imgproc.hpp>

#include "tests/synthetic/ideal_rig.hpp"
#include "tests/synthetic/sensor_recording.hpp"

namespace divemesh::pipeline {
namespace {

constexpr int kFramesAtRest = 40;
constexpr int kDisparity_px = 20;

// A rig over a floor at 10 Hz, with light that wanders over it. It rests, and then moves by 3 px a
// frame.
struct FloorRecording : synthetic::SensorRecording {
    FloorRecording() { its_rig = synthetic::ideal_cameras(synthetic::ideal_rig(320, 240, 300.0)); }

    int num_frames() const override { return 80; }
    std::optional<types::StereoFrame> frame(int index) const override {
        types::StereoFrame result;
        result.index = index;
        result.timestamp_ns = std::int64_t{100'000'000} * index;
        const int moved_px = 3 * std::max(0, index - kFramesAtRest);
        const int light_px = moved_px - index;  // the light wanders by a pixel a frame
        result.left = half(floor_, moved_px) + half(light_, light_px);
        result.right =
            half(floor_, moved_px + kDisparity_px) + half(light_, light_px + kDisparity_px);
        return result;
    }

private:
    // Returns the part of a texture that the camera sees, half as bright.
    static cv::Mat half(const cv::Mat& texture, int from_px) {
        return 0.5 * texture(cv::Rect(100 + from_px, 0, 320, 240));
    }
    // Returns a texture of blobs of many sizes.
    static cv::Mat texture(std::uint64_t seed) {
        cv::Mat sum = cv::Mat::zeros(240, 640, CV_32F);
        cv::RNG random(seed);
        for (int scale = 2; scale <= 32; scale *= 2) {
            cv::Mat noise(240 / scale, 640 / scale, CV_32F);
            random.fill(noise, cv::RNG::NORMAL, 0.0, 16.0);
            cv::resize(noise, noise, sum.size(), 0, 0, cv::INTER_CUBIC);
            sum += noise;
        }
        sum.convertTo(sum, CV_8U, 1.0, 128.0);
        return sum;
    }

    cv::Mat floor_ = texture(1);
    cv::Mat light_ = texture(2);
};

TEST(RangeWindowsTest, OnlyWindowsInWhichTheRigMovesHaveMatches) {
    const FloorRecording recording;
    const camera::Rectifier rectifier(recording.rig(), {}, 1);

    const auto windows =
        track_windows(recording, rectifier, {2, 10, 15, 50, 60}, recording.num_frames(), 1);

    ASSERT_EQ(windows.size(), 5U);
    for (std::size_t i = 0; i < 3; ++i) EXPECT_TRUE(windows[i].matches.empty()) << i;
    for (std::size_t i = 3; i < 5; ++i) {
        EXPECT_GE(windows[i].matches.size(), 15U) << i;
        // 15 px in half a second, at a depth of 300 * 0.12 / 20 m.
        EXPECT_NEAR(windows[i].T_after_before.translation().x(), -0.09, 0.02) << i;
    }
}

// Too short a recording does not tell a rest.
TEST(RangeWindowsTest, AShortRecordingHasItsWindows) {
    struct ShortRecording : FloorRecording {
        int num_frames() const override { return 12; }
        std::optional<types::StereoFrame> frame(int index) const override {
            return FloorRecording::frame(index + kFramesAtRest);
        }
    } recording;
    const camera::Rectifier rectifier(recording.rig(), {}, 1);

    const auto windows = track_windows(recording, rectifier, {2}, recording.num_frames(), 1);

    ASSERT_EQ(windows.size(), 1U);
    EXPECT_GE(windows[0].matches.size(), 15U);
}

}  // namespace
}  // namespace divemesh::pipeline
