#include "worker/video/clock_offset.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "tests/temporary_folder.hpp"
#include "tests/worker/video/video_writer.hpp"
#include "worker/video/find_offset.hpp"
#include "worker/video/motion_offset.hpp"
#include "worker/video/plan_pairs.hpp"

namespace divemesh::video {
namespace {

namespace fs = std::filesystem;

constexpr int kSound_hz = 48000;

void no_progress(const Progress&) {}

// Gives the sound of a dive at any time: noise that swells with breaths and bubbles.
class Scene {
public:
    explicit Scene(double duration_s) {
        cv::RNG random(11);
        noise_.resize(static_cast<std::size_t>(duration_s * kSound_hz));
        double level = 0.1;
        for (std::size_t i = 0; i < noise_.size(); ++i) {
            if (i % 1200 == 0) level = std::exp(random.gaussian(1.0)) * 0.05;
            noise_[i] = static_cast<float>(std::clamp(level * random.gaussian(1.0), -0.7, 0.7));
        }
    }

    // Returns what a camera records that starts at `start_s` with a clock that runs fast by
    // `drift`, with noise of its own.
    std::vector<float> recorded(double start_s, double duration_s, double drift, int seed) const {
        cv::RNG random(static_cast<std::uint64_t>(seed));
        std::vector<float> samples(static_cast<std::size_t>(duration_s * kSound_hz));
        for (std::size_t i = 0; i < samples.size(); ++i) {
            const double at = start_s * kSound_hz + static_cast<double>(i) * (1.0 - drift);
            const auto before = static_cast<std::size_t>(at);
            const auto share = static_cast<float>(at - std::floor(at));
            const float heard = before + 1 < noise_.size()
                                    ? (1.0F - share) * noise_[before] + share * noise_[before + 1]
                                    : 0.0F;
            samples[i] = heard + static_cast<float>(0.02 * random.gaussian(1.0));
        }
        return samples;
    }

private:
    std::vector<float> noise_;
};

class ClockOffsetTest : public testing::Test {
protected:
    fs::path written(const std::string& name,
                     const WrittenVideo& video,
                     const std::vector<float>& sound,
                     int num_frames,
                     const std::function<cv::Mat(int)>& image) {
        VideoWriter writer(folder_ / name, video);
        if (!video.audio_codec.empty()) writer.add_sound(sound);
        for (int i = 0; i < num_frames; ++i) writer.add_frame(image(i), i);
        writer.finish();
        return folder_ / name;
    }

    static WrittenVideo with_sound(const std::string& codec) {
        WrittenVideo video;
        video.codec = "libx264";
        video.pixel_format = "yuv420p";
        video.ticks_hz = 30;
        video.audio_codec = codec;
        return video;
    }

    static IndexedVideo indexed(const fs::path& path) {
        return one_file(path, read_index(path, no_progress));
    }

    TemporaryFolder folder_;
};

cv::Mat grey(int) { return cv::Mat(48, 64, CV_8UC3, cv::Scalar::all(90)); }

TEST_F(ClockOffsetTest, SoundGivesTheOffsetToAThirdOfAMillisecond) {
    const Scene scene(60.0);
    for (const auto& [codec, name] :
         {std::pair("aac", "r.mp4"), std::pair("pcm_s16le", "r.mov"), std::pair("aac", "r.mkv")})
        for (const double offset_s : {3.2171, -5.50037, 0.0}) {
            const auto left =
                written("l.mp4", with_sound("aac"), scene.recorded(8.0, 30.0, 0.0, 1), 900, grey);
            const auto right = written(
                name, with_sound(codec), scene.recorded(8.0 + offset_s, 28.0, 0.0, 2), 840, grey);
            const IndexedVideo videos[2] = {indexed(left), indexed(right)};
            dive::FindingLog findings;
            const ClockOffset clock =
                find_offset(videos[0], videos[1], std::nullopt, findings, no_progress);
            // MKV has no stamps before 0, so those of the first image make room for the sound's.
            const std::int64_t first_ns = clock.left_ns(videos[1].index.stamps_ns.front());
            EXPECT_NEAR(1e-9 * static_cast<double>(first_ns), offset_s, 0.3e-3) << name;
            EXPECT_LT(clock.sigma_s, 0.3e-3);
            EXPECT_EQ(clock.drift, 0.0);
            ASSERT_EQ(findings.all().size(), 1U);
            EXPECT_EQ(findings.all()[0].code, "video_offset");
        }
}

TEST_F(ClockOffsetTest, SoundOfMinutesGivesTheDrift) {
    constexpr double kDrift = 60e-6;
    const Scene scene(340.0);
    SoundEnvelope sounds[2];
    for (int side = 0; side < 2; ++side) {
        WrittenVideo video = with_sound("pcm_s16le");
        const auto path = written(
            "d.mov", video, scene.recorded(4.0 * side, 320.0, side * kDrift, 5 + side), 3, grey);
        sounds[side] = read_sound({{path, 0, 0}}, 1200.0, no_progress);
    }
    const auto clock = offset_by_sound(sounds[0], sounds[1]);
    ASSERT_TRUE(clock);
    // A right stamp r is at 4 + r (1 - drift) on the left clock.
    EXPECT_NEAR(clock->drift, -kDrift, 3e-6);
    EXPECT_NEAR(clock->offset_s, 4.0, 0.5e-3);
}

TEST_F(ClockOffsetTest, SoundsOfDifferentDivesAreNotClear) {
    cv::RNG random(3);
    SoundEnvelope sounds[2];
    for (SoundEnvelope& sound : sounds)
        for (int i = 0; i < 160'000; ++i)
            sound.loudness.push_back(static_cast<float>(std::abs(random.gaussian(1.0))));
    EXPECT_FALSE(offset_by_sound(sounds[0], sounds[1]));
    sounds[0].loudness.assign(160'000, 0.0F);  // silence
    EXPECT_FALSE(offset_by_sound(sounds[0], sounds[1]));
    EXPECT_FALSE(offset_by_sound(sounds[0], sounds[0]));
    EXPECT_FALSE(offset_by_sound({}, sounds[1]));
    EXPECT_FALSE(offset_by_sound({}, {}));
}

// The texture of a bottom, seen by a camera that sways as a diver does, never twice the same.
cv::Mat swayed(const cv::Mat& bottom, double time_s) {
    cv::RNG random(8);
    double x = 140.0;
    double y = 140.0;
    for (int i = 0; i < 12; ++i) {
        const double rate = random.uniform(0.8, 9.0);  // rad/s
        x += 30.0 / rate * std::sin(rate * time_s + random.uniform(0.0, 6.0));
        y += 30.0 / rate * std::sin(1.1 * rate * time_s + random.uniform(0.0, 6.0));
    }
    cv::Mat seen;
    const cv::Mat shift = (cv::Mat_<double>(2, 3) << 1, 0, -x, 0, 1, -y);
    cv::warpAffine(bottom, seen, shift, {160, 120}, cv::INTER_LINEAR);
    return seen;
}

TEST_F(ClockOffsetTest, MotionGivesTheOffsetToAFractionOfAFrame) {
    cv::Mat bottom(420, 460, CV_8UC1);
    cv::RNG(4).fill(bottom, cv::RNG::UNIFORM, 0, 256);
    cv::GaussianBlur(bottom, bottom, {}, 2.5);
    cv::normalize(bottom, bottom, 0, 255, cv::NORM_MINMAX);
    WrittenVideo video;
    video.codec = "libx264";
    video.pixel_format = "gray";
    video.width_px = 160;
    video.height_px = 120;
    video.ticks_hz = 30;
    for (const double offset_s : {1.21, -2.34}) {
        const auto left =
            written("l.mkv", video, {}, 450, [&](int i) { return swayed(bottom, 5.0 + i / 30.0); });
        const auto right = written("r.mkv", video, {}, 420, [&](int i) {
            return swayed(bottom, 5.0 + offset_s + i / 30.0);
        });
        dive::FindingLog findings;
        const ClockOffset clock =
            find_offset(indexed(left), indexed(right), std::nullopt, findings, no_progress);
        EXPECT_NEAR(clock.offset_s, offset_s, 0.5 / 30.0);
        EXPECT_GT(clock.sigma_s, 0.0);
        EXPECT_EQ(findings.all().at(0).code, "video_offset");
    }
}

TEST_F(ClockOffsetTest, FileTimesFinerThanASecondAndTimecodesAreUsedWhereNothingElseTells) {
    WrittenVideo left = with_sound("");
    WrittenVideo right = left;
    left.creation_time = "2026-05-01T10:00:00.250000Z";
    right.creation_time = "2026-05-01T10:00:01.500000Z";
    dive::FindingLog findings;
    const auto clock = find_offset(indexed(written("l.mkv", left, {}, 90, grey)),
                                   indexed(written("r.mkv", right, {}, 90, grey)),
                                   std::nullopt,
                                   findings,
                                   no_progress);
    EXPECT_NEAR(clock.offset_s, 1.25, 1e-6);
    left.timecode = "10:20:30:05";
    right.timecode = "10:20:31:20";
    const auto coarse = find_offset(indexed(written("l.mov", left, {}, 90, grey)),
                                    indexed(written("r.mov", right, {}, 90, grey)),
                                    std::nullopt,
                                    findings,
                                    no_progress);
    EXPECT_NEAR(coarse.offset_s, 1.5, 1e-6);
    EXPECT_GT(coarse.sigma_s, 0.01);
}

TEST_F(ClockOffsetTest, WhatNothingTellsIsAWarning) {
    dive::FindingLog findings;
    const auto clock = find_offset(indexed(written("l.mp4", with_sound(""), {}, 60, grey)),
                                   indexed(written("r.mp4", with_sound(""), {}, 60, grey)),
                                   std::nullopt,
                                   findings,
                                   no_progress);
    EXPECT_EQ(clock.offset_s, 0.0);
    ASSERT_EQ(findings.all().size(), 1U);
    EXPECT_EQ(findings.all()[0].code, "video_offset_unknown");
    EXPECT_EQ(findings.all()[0].severity, Severity::Warning);
}

TEST(PlanPairsTest, TheNearestFramesOfEachMomentAreTaken) {
    std::vector<std::int64_t> left_ns;
    std::vector<std::int64_t> right_ns;
    for (int i = 0; i < 300; ++i) left_ns.push_back(std::llround(i * 1e9 / 30.0));
    for (int i = 0; i < 300; ++i) right_ns.push_back(std::llround(i * 1e9 / 29.97) - 2'000'000'000);
    const auto pairs = plan_pairs(left_ns, right_ns, {2.004, 0.0, 0.0}, 10.0);
    EXPECT_EQ(pairs.size(), 100U);
    for (std::size_t i = 0; i < pairs.size(); ++i) {
        EXPECT_EQ(pairs[i].left_ns, std::llround(static_cast<double>(i) * 1e8));
        // No right frame is nearer.
        for (const std::int64_t stamp_ns : right_ns)
            EXPECT_GE(std::abs(stamp_ns + 2'004'000'000 - pairs[i].left_ns),
                      std::abs(pairs[i].right_ns + 2'004'000'000 - pairs[i].left_ns));
    }
}

TEST(PlanPairsTest, OneVideoIsLongerPausesOrIsSlow) {
    std::vector<std::int64_t> left_ns;
    std::vector<std::int64_t> right_ns;
    for (int i = 0; i < 200; ++i) left_ns.push_back(50'000'000LL * i);
    for (int i = 40; i < 60; ++i) right_ns.push_back(50'000'000LL * i);
    for (int i = 100; i < 120; ++i) right_ns.push_back(50'000'000LL * i);
    EXPECT_EQ(plan_pairs(left_ns, right_ns, {}, 10.0).size(), 20U);
    EXPECT_EQ(plan_pairs(left_ns, right_ns, {}, 60.0).size(), 40U);
    EXPECT_EQ(plan_pairs(left_ns, left_ns, {}, 20.0).size(), 200U);
    EXPECT_TRUE(plan_pairs(left_ns, right_ns, {100.0, 0.0, 0.0}, 10.0).empty());
    EXPECT_TRUE(plan_pairs({}, right_ns, {}, 10.0).empty());
    EXPECT_EQ(plan_pairs({0}, {0}, {}, 10.0).size(), 1U);
}

}  // namespace
}  // namespace divemesh::video
