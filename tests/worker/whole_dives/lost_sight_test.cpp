#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>
#include <optional>

#include "schemas/verdict.hpp"
#include "tests/synthetic/altered_recording.hpp"
#include "tests/temporary_folder.hpp"
#include "worker/dive/dive.hpp"
#include "worker/evaluation/tracking_segments.hpp"
#include "worker/evaluation/trajectory_error.hpp"
#include "worker/pipeline/reconstruct.hpp"
#include "worker/simulator/simulate.hpp"

namespace divemesh::pipeline {
namespace {

// Makes the images between two times blank, as in a cloud of silt.
synthetic::AlteredRecording::Alter blank(double from_s, double to_s) {
    return [=, first_ns = std::optional<std::int64_t>()](types::StereoFrame& frame) mutable {
        if (!first_ns) first_ns = frame.timestamp_ns;
        const double time_s = 1e-9 * static_cast<double>(frame.timestamp_ns - *first_ns);
        if (time_s < from_s || time_s >= to_s) return;
        frame.left = cv::Mat(frame.left.size(), frame.left.type(), cv::mean(frame.left));
        frame.right = cv::Mat(frame.right.size(), frame.right.type(), cv::mean(frame.right));
    };
}

// Two laps around the same small path.
class LostSightTest : public testing::Test {
protected:
    static void SetUpTestSuite() {
        folder_ = std::make_unique<TemporaryFolder>();
        simulator::simulate({.scene = simulator::SceneKind::Tank,
                             .out = *folder_ / "dive",
                             .length_m = 1.6,
                             .rate_hz = 8.0,
                             .laps = 2,
                             .width_px = 320,
                             .height_px = 240});
    }
    static void TearDownTestSuite() { folder_.reset(); }

    types::OptimisedTrack swim(double from_s, double to_s, const nlohmann::json& overrides) {
        synthetic::AlteredRecording blanked(*dive_, blank(from_s, to_s));
        nlohmann::json all = overrides;
        all["surface"] = false;
        const ReconstructionOptions options = make_options("standard", all);
        const keyframes::KeyframeStore store(*folder_ / "keyframes");
        const types::Track track = pipeline::track(blanked, options, store, base::ignore_progress);
        num_tracked_ = track.statistics.num_frames_tracked;
        return pipeline::optimise(track, blanked, options, store, {}, base::ignore_progress);
    }
    std::vector<types::TrackingSegment> segments(const types::OptimisedTrack& track) const {
        return evaluation::segments_of(track.trajectory, track.keyframes, track.breaks_ns);
    }
    std::size_t num_segments(const types::OptimisedTrack& track) const {
        return segments(track).size();
    }
    double path_length_m(const types::OptimisedTrack& track) const {
        double length_m = 0.0;
        for (const auto& segment : segments(track)) length_m += segment.path_length_m;
        return length_m;
    }
    static bool has(const types::OptimisedTrack& track, const std::string& code) {
        return std::any_of(track.findings.begin(), track.findings.end(), [&](const Finding& of) {
            return of.code == code;
        });
    }
    double ate_m(const types::OptimisedTrack& track) const {
        return evaluation::trajectory_error(track.trajectory, dive_->ground_truth()).ate_rmse_m;
    }

    static inline std::unique_ptr<TemporaryFolder> folder_;
    std::unique_ptr<dive::Dive> dive_ = dive::Dive::open(*folder_ / "dive", *folder_ / "scratch");
    std::int64_t num_tracked_ = 0;
};

TEST_F(LostSightTest, InertiaCarriesTheDiveOverTwoSecondsOfBlankImages) {
    const types::OptimisedTrack track = swim(2.0, 4.0, {});
    EXPECT_LE(num_tracked_, dive_->num_frames() - 16);
    EXPECT_EQ(num_segments(track), 1U);
    EXPECT_LT(ate_m(track), 0.02);
    EXPECT_TRUE(track.calibration.is_known());
    EXPECT_EQ(track.covariances.size(), track.trajectory.size());
    EXPECT_GE(track.predicted.size(), 15U);
    EXPECT_TRUE(has(track, "tracking_lost"));
}

TEST_F(LostSightTest, HalfASecondIsMeasuredByTheImu) {
    const types::OptimisedTrack track = swim(2.0, 2.5, {});
    EXPECT_TRUE(track.predicted.empty());
    EXPECT_EQ(std::ssize(track.trajectory), dive_->num_frames());
    EXPECT_FALSE(has(track, "tracking_lost"));
    EXPECT_LT(ate_m(track), 0.02);
}

TEST_F(LostSightTest, ADiveThatBeginsInTheDarkBeginsWhereItSees) {
    const types::OptimisedTrack track = swim(-1.0, 3.0, {});
    EXPECT_EQ(num_segments(track), 1U);
    EXPECT_EQ(track.predicted.size(), 24U);
    EXPECT_LT(ate_m(track), 0.02);
}

TEST_F(LostSightTest, WithoutInertiaALoopJoinsTheSegments) {
    const types::OptimisedTrack track = swim(2.0, 4.0, {{"use_imu", false}, {"use_ahrs", false}});
    EXPECT_EQ(num_segments(track), 1U);
    EXPECT_LT(ate_m(track), 0.02);
    EXPECT_TRUE(track.calibration.is_known());
}

TEST_F(LostSightTest, WithoutInertiaAndLoopsItStaysInTwoSegments) {
    const types::OptimisedTrack track =
        swim(2.0, 4.0, {{"use_imu", false}, {"use_ahrs", false}, {"close_loops", false}});
    EXPECT_EQ(num_segments(track), 2U);
    EXPECT_TRUE(track.calibration.is_known());
    // Without the two seconds of blank images, and without the way from one segment to the other.
    EXPECT_LT(path_length_m(track), 2.9);
    EXPECT_GT(path_length_m(track), 2.2);
}

TEST_F(LostSightTest, AlmostOnlyBlankImagesGiveNoModel) {
    for (const char* estimator : {"window", "pairwise"}) {
        const types::OptimisedTrack track = swim(0.5, 1e3, {{"estimator", estimator}});
        EXPECT_TRUE(has(track, "nothing_reconstructed")) << estimator;
        EXPECT_EQ(verdict_on(track.findings), Verdict::NotUsable) << estimator;
        EXPECT_LE(track.trajectory.size(), 5U) << estimator;
    }
}

}  // namespace
}  // namespace divemesh::pipeline
