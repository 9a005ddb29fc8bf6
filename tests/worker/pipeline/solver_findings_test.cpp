#include "worker/pipeline/solver_findings.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <string>

#include "worker/pipeline/alignment_findings.hpp"

namespace divemesh::pipeline {
namespace {

types::TrackStatistics tracked(std::int64_t num_tracked, std::int64_t num_frames) {
    types::TrackStatistics track;
    track.num_frames = num_frames;
    track.num_frames_tracked = num_tracked;
    return track;
}

TEST(WindowFindingsTest, AWindowThatStopsAtItsLimitIsNoFinding) {
    types::TrackStatistics track = tracked(100, 100);
    track.window_solver = {.num_solves = 40, .num_stopped_at_limit = 40};
    EXPECT_TRUE(window_findings(track).empty());
    track.window_solver.num_failed = 4;
    ASSERT_EQ(window_findings(track).size(), 1U);
    EXPECT_EQ(window_findings(track)[0].code, "solver_failed");
}

TEST(WindowFindingsTest, MotionsThatOftenStopWhileStillMovingAreToldOnce) {
    types::TrackStatistics track = tracked(100, 100);
    track.pose_solver = {.num_solves = 100, .num_stopped_at_limit = 50, .num_still_moving = 5};
    EXPECT_TRUE(window_findings(track).empty());
    track.pose_solver.num_still_moving = 6;
    ASSERT_EQ(window_findings(track).size(), 1U);
    EXPECT_EQ(window_findings(track)[0].code, "solver_not_converged");
}

TEST(SolverFindingsTest, ALastStepOfMoreThanItsNoiseIsAFinding) {
    types::SolverOutcome outcome;
    outcome.termination = types::SolverOutcome::Termination::StoppedAtLimit;
    outcome.last_step_sigmas = 0.9;
    EXPECT_TRUE(solver_findings(outcome, "code", "it").empty());
    outcome.last_step_sigmas = 2.5;
    const std::vector<Finding> findings = solver_findings(outcome, "code", "it");
    ASSERT_EQ(findings.size(), 1U);
    EXPECT_NE(findings[0].message.find("2.5 standard deviations"), std::string::npos);
}

TEST(SolverTallyTest, CountsWhatIsStillMoving) {
    types::SolverOutcome outcome;
    outcome.termination = types::SolverOutcome::Termination::StoppedAtLimit;
    types::SolverTally tally;
    tally.add(outcome);
    outcome.last_decrease = 0.2;
    tally.add(outcome);
    EXPECT_EQ(tally.num_stopped_at_limit, 2);
    EXPECT_EQ(tally.num_still_moving, 1);
}

TEST(AlignmentFindingsTest, ImagesThatDoNotBelongTogetherAreTold) {
    types::RigAlignment alignment;  // as of left and right images of two places
    alignment.num_pairs = 23;
    alignment.num_matches = 53;
    ASSERT_EQ(alignment_findings(alignment).size(), 1U);
    EXPECT_EQ(alignment_findings(alignment)[0].code, "stereo_unmatched");
    alignment.num_matches = 550;
    EXPECT_TRUE(alignment_findings(alignment).empty());
    alignment.num_matches = 3;
    alignment.num_pairs = 1;
    EXPECT_TRUE(alignment_findings(alignment).empty()) << "one pair says little";
}

TEST(AlignmentFindingsTest, EachKnockInMidDiveIsToldWithItsTime) {
    types::RigAlignment alignment;
    alignment.outcome = types::RigAlignment::Outcome::AsStated;
    alignment.num_pairs = 48;
    alignment.num_matches = 9000;
    alignment.num_inliers = 8000;
    types::RigPart turned{.first_frame = 60, .num_frames = 90, .from_ns = 7'000'000'000};
    turned.found = true;
    turned.values[types::RigChange::kPitch] = 0.01;
    turned.values[types::RigChange::kFocal] = 0.02;
    alignment.parts = {{.num_frames = 60, .from_ns = 1'000'000'000, .found = true},
                       turned,
                       {.first_frame = 150, .num_frames = 20, .from_ns = 16'000'000'000}};

    const std::vector<Finding> findings = alignment_findings(alignment);

    ASSERT_EQ(findings.size(), 2U);
    EXPECT_EQ(findings[0].code, "rig_moved");
    EXPECT_EQ(findings[0].message.find("after 6.0 s (frame 60) something moved"), 0U);
    EXPECT_NE(findings[0].message.find("pitch 0.57"), std::string::npos);
    EXPECT_EQ(findings[0].message.find("yaw"), std::string::npos) << "no range tells it";
    EXPECT_EQ(findings[1].message.find("focal"), std::string::npos) << "nothing is known of it";
    EXPECT_NE(findings[1].message.find("too few points"), std::string::npos);
}

TEST(AlignmentFindingsTest, OpenWaterBetweenPartsOfOneRigIsNoKnock) {
    types::RigAlignment alignment;
    alignment.outcome = types::RigAlignment::Outcome::AsStated;
    alignment.num_pairs = 24;
    alignment.num_matches = 3825;
    alignment.num_inliers = 3758;
    const auto part = [](int first, bool found, double pitch_rad) {
        types::RigPart made{
            .first_frame = first, .num_frames = 60, .from_ns = first * 100'000'000L};
        made.found = found;
        made.values[types::RigChange::kPitch] = pitch_rad;
        return made;
    };
    alignment.parts = {part(0, true, 0.0), part(60, false, 0.0), part(120, true, 0.0001)};
    EXPECT_TRUE(alignment_findings(alignment).empty());
    alignment.parts[0].found = false;
    EXPECT_TRUE(alignment_findings(alignment).empty()) << "the dive begins in open water";
    alignment.parts[0].found = true;
    alignment.parts[2] = part(120, true, 0.01);
    ASSERT_EQ(alignment_findings(alignment).size(), 1U);
    EXPECT_NE(alignment_findings(alignment)[0].message.find("frame 60) something moved"),
              std::string::npos);
}

TEST(SolverFindingsTest, RowsThatAreOffAreToldEvenIfNothingIsCorrected) {
    types::RigAlignment alignment;
    alignment.outcome = types::RigAlignment::Outcome::AsStated;
    alignment.num_pairs = 6;
    alignment.num_matches = 153;
    alignment.num_inliers = 111;
    alignment.row_shift_px = 0.5;
    EXPECT_TRUE(alignment_findings(alignment).empty());
    alignment.row_shift_px = 1.6;
    ASSERT_EQ(alignment_findings(alignment).size(), 1U);
    EXPECT_EQ(alignment_findings(alignment)[0].code, "stereo_mismatch");
    EXPECT_NE(alignment_findings(alignment)[0].message.find("1.6 px"), std::string::npos);
}

// A failed solve is a finding, and so is one that stopped too early.
TEST(AlignmentFindingsTest, ASolveThatFailsOrIsStillMovingIsTold) {
    types::RigAlignment alignment;
    alignment.outcome = types::RigAlignment::Outcome::AsStated;
    alignment.row_solver = {.num_solves = 1, .num_converged = 1};
    alignment.range_solver = {.num_solves = 1, .num_stopped_at_limit = 1};
    EXPECT_TRUE(alignment_findings(alignment).empty());
    alignment.range_solver.num_still_moving = 1;
    ASSERT_EQ(alignment_findings(alignment).size(), 1U);
    EXPECT_EQ(alignment_findings(alignment)[0].code, "alignment_not_converged");
    alignment.range_solver = {.num_solves = 1, .num_failed = 1};
    ASSERT_EQ(alignment_findings(alignment).size(), 1U);
    EXPECT_NE(alignment_findings(alignment)[0].message.find("failed"), std::string::npos);
    alignment.outcome = types::RigAlignment::Outcome::Inconsistent;  // as failed rows leave it
    alignment.row_solver = {.num_solves = 1, .num_failed = 1};
    ASSERT_EQ(alignment_findings(alignment).size(), 1U);
    EXPECT_EQ(alignment_findings(alignment)[0].code, "alignment_not_converged");
}

TEST(SolverFindingsTest, ALimitMattersWhileTheCostIsStillFalling) {
    types::SolverOutcome outcome;
    outcome.termination = types::SolverOutcome::Termination::Converged;
    EXPECT_TRUE(solver_findings(outcome, "code", "it").empty());
    outcome.termination = types::SolverOutcome::Termination::StoppedAtLimit;
    outcome.last_decrease = 1e-4;
    EXPECT_TRUE(solver_findings(outcome, "code", "it").empty());
    outcome.last_decrease = 0.2;
    ASSERT_EQ(solver_findings(outcome, "code", "it").size(), 1U);
    outcome.termination = types::SolverOutcome::Termination::Failed;
    ASSERT_EQ(solver_findings(outcome, "code", "it").size(), 1U);
    EXPECT_EQ(solver_findings(outcome, "code", "it")[0].code, "code");
}

class DivergenceTest : public testing::Test {
protected:
    DivergenceTest() {
        for (int i = 0; i < 100; ++i) {
            types::StampedPose pose{.timestamp_ns = i};
            pose.T_world_imu.translation().x() = 0.1 * i;
            track_.odometry.push_back(pose);
        }
        result_.trajectory = track_.odometry;
        result_.keyframes = {{.timestamp_ns = 0}, {.timestamp_ns = 50}, {.timestamp_ns = 99}};
        result_.statistics.check.after.reprojection_rms_px = 0.4;
    }
    bool diverged() const {
        const auto finding = divergence(track_, result_);
        return finding && finding->severity == Severity::Error;
    }

    types::Track track_;
    types::OptimisedTrack result_;
};

TEST_F(DivergenceTest, APathThatAgreesIsTaken) { EXPECT_FALSE(diverged()); }

TEST_F(DivergenceTest, AReprojectionOfSixPixelsIsNoModel) {
    result_.statistics.check.after.reprojection_rms_px = 6.0;
    EXPECT_TRUE(diverged());
}

TEST_F(DivergenceTest, APoseThatIsNotFiniteIsNoModel) {
    result_.trajectory[7].T_world_imu.translation().x() = std::numeric_limits<double>::infinity();
    EXPECT_TRUE(diverged());
}

TEST_F(DivergenceTest, APathOfManyTimesTheOdometryIsNoModel) {
    for (types::StampedPose& pose : result_.trajectory) pose.T_world_imu.translation() *= 12.0;
    EXPECT_TRUE(diverged());
}

TEST_F(DivergenceTest, TheDistanceBetweenSegmentsDoesNotCount) {
    result_.keyframes[1].segment = result_.keyframes[2].segment = 1;
    for (std::size_t i = 50; i < 100; ++i)
        result_.trajectory[i].T_world_imu.translation().x() += 500.0;
    EXPECT_FALSE(diverged());
}

TEST_F(DivergenceTest, UnmeasuredMotionDoesNotCount) {
    result_.breaks_ns = {50};
    for (std::size_t i = 50; i < 100; ++i)
        result_.trajectory[i].T_world_imu.translation().x() += 500.0;
    EXPECT_FALSE(diverged());
}

}  // namespace
}  // namespace divemesh::pipeline
