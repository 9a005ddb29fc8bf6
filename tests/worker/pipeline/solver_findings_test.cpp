#include "worker/pipeline/solver_findings.hpp"

#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <string>

#include "schemas/error.hpp"

namespace divemesh::pipeline {
namespace {

types::TrackStatistics tracked(std::int64_t num_tracked, std::int64_t num_frames) {
    types::TrackStatistics track;
    track.num_frames = num_frames;
    track.num_frames_tracked = num_tracked;
    return track;
}

ErrorCode code_of(const std::function<void()>& call) {
    try {
        call();
    } catch (const Error& error) {
        return error.code();
    }
    ADD_FAILURE() << "nothing was thrown";
    return ErrorCode::Unavailable;
}

TEST(RequireTrackedTest, NextToNoFrameByVisionIsNoModel) {
    EXPECT_EQ(code_of([] { require_tracked(tracked(3, 250)); }), ErrorCode::BadData);  // 1.2 %
    EXPECT_EQ(code_of([] { require_tracked(tracked(1, 6)); }), ErrorCode::BadData);
    EXPECT_NO_THROW(require_tracked(tracked(1, 1)));
    EXPECT_NO_THROW(require_tracked(tracked(30, 250)));
}

TEST(TrackingFindingsTest, TheSeverityGoesByTheShare) {
    EXPECT_TRUE(tracking_findings(tracked(250, 250)).empty());
    EXPECT_TRUE(tracking_findings(tracked(245, 250)).empty());
    const auto some = tracking_findings(tracked(220, 250));
    ASSERT_EQ(some.size(), 1U);
    EXPECT_EQ(some[0].code, "tracking_lost");
    EXPECT_EQ(some[0].severity, Severity::Info);
    const auto many = tracking_findings(tracked(100, 250));
    ASSERT_EQ(many.size(), 1U);
    EXPECT_EQ(many[0].severity, Severity::Warning);
    EXPECT_NE(many[0].message.find("150 of 249"), std::string::npos) << many[0].message;
}

TEST(TrackingFindingsTest, AWindowThatStopsAtItsLimitIsNoFinding) {
    types::TrackStatistics track = tracked(100, 100);
    track.window_solver = {.num_solves = 40, .num_stopped_at_limit = 40};
    EXPECT_TRUE(tracking_findings(track).empty());
    track.window_solver.num_failed = 4;
    ASSERT_EQ(tracking_findings(track).size(), 1U);
    EXPECT_EQ(tracking_findings(track)[0].code, "solver_failed");
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

class RequireConvergedTest : public testing::Test {
protected:
    RequireConvergedTest() {
        for (int i = 0; i < 100; ++i) {
            types::StampedPose pose{.timestamp_ns = i};
            pose.T_world_imu.translation().x() = 0.1 * i;
            track_.odometry.push_back(pose);
        }
        result_.trajectory = track_.odometry;
        result_.keyframes = {{.timestamp_ns = 0}, {.timestamp_ns = 50}, {.timestamp_ns = 99}};
        result_.statistics.check.after.reprojection_rms_px = 0.4;
    }
    void require() const { require_converged(track_, result_); }

    types::Track track_;
    types::OptimisedTrack result_;
};

TEST_F(RequireConvergedTest, APathThatAgreesIsTaken) { EXPECT_NO_THROW(require()); }

TEST_F(RequireConvergedTest, AReprojectionOfSixPixelsIsNoModel) {
    result_.statistics.check.after.reprojection_rms_px = 6.0;
    EXPECT_EQ(code_of([&] { require(); }), ErrorCode::BadData);
}

TEST_F(RequireConvergedTest, APoseThatIsNotFiniteIsNoModel) {
    result_.trajectory[7].T_world_imu.translation().x() = std::numeric_limits<double>::infinity();
    EXPECT_EQ(code_of([&] { require(); }), ErrorCode::BadData);
}

TEST_F(RequireConvergedTest, APathOfManyTimesTheOdometryIsNoModel) {
    for (types::StampedPose& pose : result_.trajectory) pose.T_world_imu.translation() *= 12.0;
    EXPECT_EQ(code_of([&] { require(); }), ErrorCode::BadData);
}

TEST_F(RequireConvergedTest, TheWayFromOneSegmentToTheNextDoesNotCount) {
    result_.keyframes[1].segment = result_.keyframes[2].segment = 1;
    for (std::size_t i = 50; i < 100; ++i)
        result_.trajectory[i].T_world_imu.translation().x() += 500.0;
    EXPECT_NO_THROW(require());
}

}  // namespace
}  // namespace divemesh::pipeline
