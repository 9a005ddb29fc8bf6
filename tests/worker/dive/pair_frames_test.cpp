#include "worker/dive/pair_frames.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "tests/worker/dive/finding_matcher.hpp"
#include "worker/dive/motion_profile.hpp"

namespace divemesh::dive {
namespace {

constexpr int kWidth_px = 320;
constexpr int kHeight_px = 240;
constexpr double kFocal_px = 250.0;
constexpr double kBaseline_m = 0.1;
constexpr double kDistance_m = 1.0;
constexpr double kPeriod_s = 0.1;
constexpr double kIgnoredDelay_s = 0.0005;  // a shorter one counts as 0
constexpr std::int64_t kStart_ns = 1'600'000'000'000'000'000;

types::Rig rig() {
    types::Rig rig;
    for (types::Camera* camera : {&rig.cam0, &rig.cam1}) {
        camera->width_px = kWidth_px;
        camera->height_px = kHeight_px;
        camera->fx_px = camera->fy_px = kFocal_px;
        camera->cx_px = 0.5 * kWidth_px;
        camera->cy_px = 0.5 * kHeight_px;
        camera->distortion = types::Distortion::None;
    }
    rig.T_imu_cam1.translation() = Eigen::Vector3d(kBaseline_m, 0.0, 0.0);
    return rig;
}

// A rig that swims over a textured wall, by a path that does not repeat itself.
class Wall {
public:
    explicit Wall(std::uint64_t seed = 7) {
        cv::Mat noise(kHeight_px + 2 * kMargin_px, kWidth_px + 2 * kMargin_px, CV_8UC1);
        cv::RNG random(seed);
        random.fill(noise, cv::RNG::UNIFORM, 0, 255);
        cv::GaussianBlur(noise, texture_, {}, 1.5);
        cv::normalize(texture_, texture_, 20, 235, cv::NORM_MINMAX);
    }

    cv::Mat seen_at(double time_s, double x_m) const {
        const double x_px = kMargin_px + kFocal_px / kDistance_m * (x_m + path_x_m(time_s));
        const double y_px = kMargin_px + kFocal_px / kDistance_m * path_y_m(time_s);
        const cv::Matx23d shift(1, 0, x_px, 0, 1, y_px);
        cv::Mat image;
        cv::warpAffine(texture_,
                       image,
                       shift,
                       {kWidth_px, kHeight_px},
                       cv::INTER_LINEAR | cv::WARP_INVERSE_MAP);
        return image;
    }

private:
    static constexpr int kMargin_px = 120;
    static double path_x_m(double t) { return 0.15 * std::sin(0.9 * t) + 0.05 * std::sin(2.3 * t); }
    static double path_y_m(double t) {
        return 0.15 * std::sin(0.7 * t + 1) + 0.05 * std::cos(1.9 * t);
    }

    cv::Mat texture_;
};

// What really happened: when the images were exposed, and what the clocks said.
struct Recorded {
    int num_frames = 80;
    double period_s = kPeriod_s;
    double right_late_s = 0.0;   // exposure of the right images after the left ones
    double right_clock_s = 0.0;  // difference of its clock at the start
    double right_drift = 0.0;
    double right_period_ratio = 1.0;  // of the right camera's period to that of the left one
    double trigger_jitter_s = 0.0;    // of the right camera
    double stamp_jitter_s = 0.0;      // of its timestamps alone

    // Returns the jitter of a frame in multiples of its size.
    static double jitter(int frame) {
        constexpr std::array<double, 4> kPattern = {-1.0, 1.0, 0.0, 0.0};
        return kPattern[static_cast<std::size_t>(frame % 4)];
    }
};

class PairFramesTest : public testing::Test {
protected:
    CameraImages record(const Recorded& recorded) const {
        CameraImages images;
        for (int i = 0; i < recorded.num_frames; ++i) {
            const double left_s = i * recorded.period_s;
            const double jitter = Recorded::jitter(i);
            const double right_s = left_s * recorded.right_period_ratio + recorded.right_late_s +
                                   jitter * recorded.trigger_jitter_s;
            const double right_stamp_s = right_s + recorded.right_clock_s +
                                         recorded.right_drift * right_s +
                                         jitter * recorded.stamp_jitter_s;
            images.left.push_back({stamp_ns(left_s), std::to_string(left_s)});
            images.right.push_back({stamp_ns(right_stamp_s), std::to_string(right_s)});
        }
        images.load_left = [this](const CameraRow& row) {
            return wall_.seen_at(std::stod(row.file), 0.0);
        };
        images.load_right = [this](const CameraRow& row) {
            return wall_.seen_at(std::stod(row.file), kBaseline_m);
        };
        return images;
    }

    static std::int64_t stamp_ns(double time_s) {
        return kStart_ns + static_cast<std::int64_t>(std::llround(time_s * 1e9));
    }

    // Returns how much later the right image of a pair was exposed, by what really happened.
    static double true_delay_s(const FramePair& pair) {
        return std::stod(pair.right) - std::stod(pair.left);
    }

    // Returns the largest time between the exposures of a pair, by what really happened.
    static double max_apart_s(const PairedFrames& frames) {
        double apart_s = 0.0;
        for (const FramePair& pair : frames.pairs)
            apart_s = std::max(apart_s, std::abs(true_delay_s(pair)));
        return apart_s;
    }

    // Returns the largest error of what is known of that time.
    static double max_delay_error_s(const PairedFrames& frames) {
        double error_s = 0.0;
        for (const FramePair& pair : frames.pairs)
            error_s = std::max(error_s, std::abs(frames.right_delay_s(pair) - true_delay_s(pair)));
        return error_s;
    }

    static FindingLog report(const PairedFrames& frames, const CameraImages& images) {
        FindingLog log;
        report_pairs(frames, images, kBaseline_m, log);
        return log;
    }

    Wall wall_;
};

TEST_F(PairFramesTest, CamerasThatFireTogetherGetNoFinding) {
    const CameraImages images = record({});

    const PairedFrames frames = pair_frames(images, rig());

    EXPECT_EQ(frames.pairs.size(), 80U);
    EXPECT_TRUE(frames.clocks.is_zero());
    EXPECT_NEAR(frames.delay.delay_s, 0.0, 1e-3);
    EXPECT_TRUE(report(frames, images).all().empty());
}

TEST_F(PairFramesTest, AClockThatIsLateByLessThanAFrameIsFoundAndPaired) {
    Recorded recorded;
    recorded.right_clock_s = 0.02;
    const CameraImages images = record(recorded);

    const PairedFrames frames = pair_frames(images, rig());

    EXPECT_EQ(frames.pairs.size(), 80U);
    EXPECT_LT(max_apart_s(frames), 1e-6);
    EXPECT_NEAR(static_cast<double>(frames.clocks.offset_ns), 0.02e9, 1e6);
    EXPECT_THAT(
        report(frames, images).all(),
        HasFinding(Severity::Warning, "camera_clocks_differ", "constant difference of 0.02"));
}

TEST_F(PairFramesTest, ClocksSecondsOrYearsApartAreFoundByTheMotionOfBothImages) {
    for (const double clock_s : {1.3, -2.1, -1.2e9}) {
        Recorded recorded;
        recorded.right_clock_s = clock_s;

        const PairedFrames frames = pair_frames(record(recorded), rig());

        EXPECT_GE(frames.pairs.size(), 79U) << clock_s;
        EXPECT_LT(max_apart_s(frames), 1e-6) << clock_s;
    }
}

TEST_F(PairFramesTest, TwoClocksThatDriftApartArePairedToTheEnd) {
    Recorded recorded;
    recorded.num_frames = 160;
    recorded.right_clock_s = 0.3;
    recorded.right_drift = 0.008;  // 0.13 s over the dive, more than a frame
    const CameraImages images = record(recorded);

    const PairedFrames frames = pair_frames(images, rig());

    EXPECT_EQ(frames.pairs.size(), 160U);
    EXPECT_LT(max_apart_s(frames), 1e-6);
    EXPECT_NEAR(frames.clocks.drift, 0.008, 0.001);
    EXPECT_THAT(report(frames, images).all(),
                HasFinding(Severity::Warning, "camera_clocks_differ", "parts per million"));
}

TEST_F(PairFramesTest, CamerasThatFireApartAreSaidWithTheSizeOfIt) {
    for (const double late_s : {0.02, -0.03}) {
        Recorded recorded;
        recorded.right_late_s = late_s;
        const CameraImages images = record(recorded);

        const PairedFrames frames = pair_frames(images, rig());

        EXPECT_NEAR(frames.delay.delay_s, late_s, 2e-3);
        EXPECT_EQ(frames.pairs.size(), 80U);
        for (const FramePair& pair : frames.pairs)
            EXPECT_EQ(frames.right_delay_s(pair), frames.delay.delay_s);
        EXPECT_THAT(report(frames, images).all(),
                    HasFinding(Severity::Warning,
                               "frames_unsynchronised",
                               late_s > 0 ? "ms after the left" : "ms before the left"));
    }
}

// The gap sweeps from nothing to half a period and on from minus that, in time with the beat.
TEST_F(PairFramesTest, TheGapOfEachPairIsKnownOfCamerasThatRunFree) {
    for (const int rate_hz : {10, 30}) {
        Recorded recorded;
        recorded.num_frames = 8 * rate_hz;
        recorded.period_s = 1.0 / rate_hz;
        recorded.right_period_ratio = 1.0 + 1.0 / recorded.num_frames;
        const CameraImages images = record(recorded);

        const PairedFrames frames = pair_frames(images, rig());

        EXPECT_EQ(frames.gaps, PairGaps::Confirmed) << rate_hz;
        EXPECT_TRUE(frames.clocks.is_zero()) << rate_hz;
        EXPECT_GE(std::ssize(frames.pairs), recorded.num_frames - 2);
        EXPECT_GT(max_apart_s(frames), 0.45 * recorded.period_s);
        EXPECT_LT(max_delay_error_s(frames), kIgnoredDelay_s) << rate_hz;
        const auto told = report(frames, images).all();
        EXPECT_THAT(
            told, HasFinding(Severity::Warning, "frames_unsynchronised", "as the images confirm"));
        EXPECT_THAT(told, testing::Not(HasFinding(Severity::Warning, "camera_clocks_differ", "")));
    }
}

TEST_F(PairFramesTest, PairsOfATriggerThatJittersAreKeptWithTheirGaps) {
    Recorded recorded;
    recorded.trigger_jitter_s = 0.008;
    const CameraImages images = record(recorded);

    const PairedFrames frames = pair_frames(images, rig());

    EXPECT_EQ(frames.pairs.size(), 80U);
    EXPECT_EQ(frames.gaps, PairGaps::Confirmed);
    EXPECT_LT(max_delay_error_s(frames), 1e-5);
    EXPECT_THAT(report(frames, images).all(),
                HasFinding(Severity::Warning, "frames_unsynchronised", "8.0 ms at most"));
}

TEST_F(PairFramesTest, PairsThatAreHardlyApartAreNotCorrectedThoughOthersAre) {
    Recorded recorded;
    recorded.right_late_s = 2e-5;
    recorded.trigger_jitter_s = 0.008;

    const PairedFrames frames = pair_frames(record(recorded), rig());

    ASSERT_EQ(frames.gaps, PairGaps::Confirmed);
    for (const FramePair& pair : frames.pairs)
        EXPECT_NEAR(frames.right_delay_s(pair),
                    std::abs(true_delay_s(pair)) < kIgnoredDelay_s ? 0.0 : true_delay_s(pair),
                    1e-6);
}

TEST_F(PairFramesTest, ASingleOddTimestampDoesNotMakeTheGapsVary) {
    Recorded recorded;
    recorded.right_late_s = 2e-5;
    CameraImages images = record(recorded);
    images.right[20].timestamp_ns += 2'000'000;

    const PairedFrames frames = pair_frames(images, rig());

    EXPECT_EQ(frames.pairs.size(), 80U);
    EXPECT_EQ(frames.gaps, PairGaps::Constant);
    for (const FramePair& pair : frames.pairs) EXPECT_EQ(frames.right_delay_s(pair), 0.0);
}

TEST_F(PairFramesTest, GapsVaryFromTheThirdPairOnAndInLongDivesFromAShareOn) {
    for (const auto& [num_pairs, num_needed] : {std::pair{40, 3}, std::pair{1000, 20}}) {
        PairedFrames frames;
        frames.pairs.resize(static_cast<std::size_t>(num_pairs));
        for (int i = 0; i < num_needed; ++i) {
            EXPECT_FALSE(frames.gaps_vary()) << i << " of " << num_pairs;
            frames.pairs[static_cast<std::size_t>(i)].right_ns = 2'000'000;
        }
        EXPECT_TRUE(frames.gaps_vary()) << num_pairs;
    }
}

TEST_F(PairFramesTest, GapsThatOnlyTimestampsStateAreNotHeldForExact) {
    Recorded recorded;
    recorded.trigger_jitter_s = 0.008;
    CameraImages images = record(recorded);
    images.load_left = images.load_right = [](const CameraRow&) {
        return cv::Mat(kHeight_px, kWidth_px, CV_8UC1, cv::Scalar(90));
    };

    const PairedFrames frames = pair_frames(images, rig());

    EXPECT_EQ(frames.gaps, PairGaps::Stated);
    EXPECT_FALSE(frames.delay.is_determined);
    EXPECT_NEAR(frames.shared_delay_sigma_m(), 0.6e-3, 1e-6);  // 2 ms at 0.3 m/s
}

TEST_F(PairFramesTest, TheErrorOfADelayThatImagesMeasureIsTheirs) {
    EXPECT_EQ(pair_frames(record({}), rig()).shared_delay_sigma_m(), 0.0);
    Recorded recorded;
    recorded.right_late_s = 0.02;
    const PairedFrames frames = pair_frames(record(recorded), rig());
    EXPECT_EQ(frames.shared_delay_sigma_m(), frames.delay.sigma_s * frames.delay.speed_m_s);
}

TEST_F(PairFramesTest, TimestampsThatJitterAloneAreContradictedByTheImages) {
    Recorded recorded;
    recorded.stamp_jitter_s = 0.008;
    const CameraImages images = record(recorded);

    const PairedFrames frames = pair_frames(images, rig());

    EXPECT_EQ(frames.pairs.size(), 80U);
    EXPECT_EQ(frames.gaps, PairGaps::Contradicted);
    EXPECT_LT(max_delay_error_s(frames), 1e-6);
    EXPECT_THAT(report(frames, images).all(),
                HasFinding(Severity::Warning, "frames_unsynchronised", "the images fit better"));
}

// As of two videos: both number their frames at the nominal rate, and one camera is slower.
TEST_F(PairFramesTest, TheGapThatGrowsBetweenNominalTimestampsIsFoundAsADrift) {
    Recorded recorded;
    recorded.num_frames = 160;
    recorded.right_period_ratio = 1.005;  // 80 ms over the dive
    recorded.right_drift = 1.0 / recorded.right_period_ratio - 1.0;
    const CameraImages images = record(recorded);

    const PairedFrames frames = pair_frames(images, rig());

    EXPECT_EQ(frames.gaps, PairGaps::Confirmed);
    EXPECT_GT(max_apart_s(frames), 0.05);
    EXPECT_LT(max_delay_error_s(frames), 0.006);
    EXPECT_THAT(report(frames, images).all(),
                HasFinding(Severity::Warning, "frames_unsynchronised", "varies from pair to pair"));
}

TEST_F(PairFramesTest, TheSigmaOfADelayHolds) {
    for (const double late_s : {0.005, 0.01, 0.02, 0.03, -0.01}) {
        Recorded recorded;
        recorded.right_late_s = late_s;
        const StereoDelay delay = pair_frames(record(recorded), rig()).delay;
        EXPECT_TRUE(delay.is_significant()) << late_s;
        EXPECT_LT(std::abs(delay.delay_s - late_s), 2.0 * delay.sigma_s) << late_s;
        EXPECT_LT(delay.sigma_s, 2e-3) << late_s;
    }
}

// Rigs of two unlike cameras are refused with a finding of their own.
TEST_F(PairFramesTest, ImagesOfTwoSizesArePairedByTheirTimestamps) {
    CameraImages images = record({});
    images.load_right = [this](const CameraRow& row) {
        cv::Mat half;
        cv::resize(wall_.seen_at(std::stod(row.file), kBaseline_m), half, {}, 0.5, 0.5);
        return half;
    };
    const PairedFrames frames = pair_frames(images, rig());
    EXPECT_EQ(frames.pairs.size(), 80U);
    EXPECT_FALSE(frames.delay.is_determined);
}

TEST_F(PairFramesTest, ImagesThatShowNothingConfirmNoDifference) {
    Recorded recorded;
    recorded.right_clock_s = 77.0;
    CameraImages images = record(recorded);
    images.load_right = [](const CameraRow&) {
        return cv::Mat(kHeight_px, kWidth_px, CV_8UC1, cv::Scalar(90));
    };

    const PairedFrames frames = pair_frames(images, rig());

    EXPECT_TRUE(frames.pairs.empty());
    EXPECT_THAT(report(frames, images).all(),
                HasFinding(Severity::Error, "left_right_no_overlap", "cam1"));
}

// Flakes that sink in open water, each image with its own: a lag that fits them is chance, and no
// reason to doubt timestamps that agree.
TEST_F(PairFramesTest, ImagesOfOpenWaterArePairedByTheirTimestamps) {
    const Recorded recorded;
    CameraImages images = record(recorded);
    const std::int64_t start_ns = images.left.front().timestamp_ns;
    const auto water = [start_ns](std::uint64_t side) {
        return [=](const CameraRow& row) {
            const auto since_ns = static_cast<double>(row.timestamp_ns - start_ns);
            cv::Mat image(kHeight_px, kWidth_px, CV_8UC1);
            cv::RNG noise(static_cast<std::uint64_t>(row.timestamp_ns) + side);
            noise.fill(image, cv::RNG::NORMAL, 90, 2);
            cv::RNG flakes(3);
            for (int i = 0; i < 60; ++i) {
                const double u = flakes.uniform(0.0, 1.0 * kWidth_px) + noise.gaussian(4.0);
                const double v =
                    flakes.uniform(0.0, 1.0 * kHeight_px) + noise.gaussian(4.0) + 7e-9 * since_ns;
                cv::circle(image,
                           {static_cast<int>(u), static_cast<int>(v) % kHeight_px},
                           2,
                           cv::Scalar(190),
                           cv::FILLED);
            }
            return image;
        };
    };
    images.load_left = water(0);
    images.load_right = water(1);

    const PairedFrames frames = pair_frames(images, rig());

    EXPECT_EQ(frames.pairs.size(), images.left.size());
    EXPECT_TRUE(frames.clocks.is_zero());
}

// After a second few features are found again, or none: the pairs are tested by themselves.
class SlowPairFramesTest : public PairFramesTest {
protected:
    static Recorded slow(int num_frames = 40) {
        Recorded recorded;
        recorded.num_frames = num_frames;
        recorded.period_s = 1.0;
        recorded.right_clock_s = 0.02;
        return recorded;
    }
};

TEST_F(SlowPairFramesTest, AConstantDifferenceOfTheTimestampsIsTakenOff) {
    for (const int num_frames : {40, 2}) {
        const CameraImages images = record(slow(num_frames));

        const PairedFrames frames = pair_frames(images, rig());

        EXPECT_EQ(std::ssize(frames.pairs), num_frames);
        EXPECT_LT(max_apart_s(frames), 1e-6);
        EXPECT_NEAR(static_cast<double>(frames.clocks.offset_ns), 0.02e9, 1e3);
        EXPECT_GT(frames.delay.share_fitting.value_or(0.0), 0.25);
        const auto told = report(frames, images).all();
        EXPECT_FALSE(has_error(told));
        EXPECT_THAT(told, HasFinding(Severity::Warning, "camera_clocks_differ", "images match"));
    }
}

TEST_F(SlowPairFramesTest, ImagesThroughAFoggedPortStillMatch) {
    CameraImages images = record(slow());
    images.load_right = [this](const CameraRow& row) {
        cv::Mat fogged;
        cv::GaussianBlur(wall_.seen_at(std::stod(row.file), kBaseline_m), fogged, {}, 1.5);
        fogged.convertTo(fogged, CV_8U, 0.4, 130.0);
        return fogged;
    };

    const PairedFrames frames = pair_frames(images, rig());

    EXPECT_EQ(frames.pairs.size(), 40U);
    EXPECT_GT(frames.delay.share_fitting.value_or(0.0), 0.1);
}

TEST_F(SlowPairFramesTest, ImagesOfTwoScenesAreRefused) {
    const Wall other(8);
    CameraImages images = record(slow());
    images.load_right = [&other](const CameraRow& row) {
        return other.seen_at(std::stod(row.file), kBaseline_m);
    };

    const PairedFrames frames = pair_frames(images, rig());

    EXPECT_TRUE(frames.pairs.empty());
    EXPECT_TRUE(frames.delay.share_fitting.has_value());
    EXPECT_THAT(report(frames, images).all(),
                HasFinding(Severity::Error, "left_right_no_overlap", "cam1"));
}

// The right camera began three seconds later, and its clock tells nothing.
TEST_F(SlowPairFramesTest, ImagesOfOtherTimesAreNotPaired) {
    Recorded recorded = slow();
    recorded.right_clock_s = -1.2e9;
    CameraImages images = record(recorded);
    images.right.erase(images.right.begin(), images.right.begin() + 3);

    const PairedFrames frames = pair_frames(images, rig());

    EXPECT_LT(max_apart_s(frames), 0.5);
}

TEST_F(PairFramesTest, ImagesThatCannotBeTestedArePairedByTheirTimestampsWithAWarning) {
    Recorded recorded;
    recorded.right_clock_s = 0.02;
    CameraImages images = record(recorded);
    images.load_left = images.load_right = [](const CameraRow&) {
        return cv::Mat(kHeight_px, kWidth_px, CV_8UC1, cv::Scalar(90));
    };

    const PairedFrames frames = pair_frames(images, rig());

    EXPECT_EQ(frames.pairs.size(), 80U);
    EXPECT_FALSE(frames.delay.share_fitting.has_value());
    const auto told = report(frames, images).all();
    EXPECT_FALSE(has_error(told));
    EXPECT_THAT(told, HasFinding(Severity::Warning, "pairs_unconfirmed", "timestamps alone"));
}

TEST(MotionProfileTest, ALagIsFoundAndARepeatedMotionIsNotClear) {
    MotionProfile left;
    MotionProfile right;
    MotionProfile repeating;
    for (int i = 0; i < 150; ++i) {
        const double t = 0.1 * i;
        left.push_back({t, {std::sin(0.9 * t) + std::sin(2.3 * t), std::cos(1.7 * t)}});
        right.push_back({t + 1.37, left.back().flow_1_s});
        repeating.push_back({t, {std::sin(3.0 * t), 0.0}});
    }

    const auto lag = find_lag(left, right, 5.0);
    ASSERT_TRUE(lag.has_value());
    EXPECT_NEAR(lag->lag_s, 1.37, 0.03);
    EXPECT_TRUE(lag->is_clear());
    EXPECT_FALSE(find_lag(repeating, repeating, 5.0)->is_clear());
}

}  // namespace
}  // namespace divemesh::dive
