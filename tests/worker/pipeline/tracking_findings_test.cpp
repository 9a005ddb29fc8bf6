#include "worker/pipeline/tracking_findings.hpp"

#include <gtest/gtest.h>

#include "schemas/verdict.hpp"
#include "worker/pipeline/measured_poses.hpp"

namespace divemesh::pipeline {
namespace {

using types::MotionSource;

// A camera that looks down from 2 m and moves by `step_m` along x from frame to frame.
class TrackingFindingsTest : public testing::Test {
protected:
    TrackingFindingsTest() {
        track_.rig.width_px = 640;
        track_.rig.height_px = 480;
        track_.rig.focal_px = 500.0;
        track_.rig.cx_px = 320.0;
        track_.rig.cy_px = 240.0;
        track_.rig.baseline_m = 0.12;
        track_.statistics.median_depth_m = 2.0;
    }
    // Tracks 100 frames, of which the motions from `first_lost` to `last_lost` are not measured.
    void swim(double step_m, int first_lost, int last_lost, types::FrameFeatures while_lost) {
        for (int i = 0; i < 100; ++i) {
            const bool lost = i >= first_lost && i <= last_lost;
            types::StampedPose pose{500'000'000LL * i};
            pose.T_world_imu.translation().x() = step_m * i;
            track_.odometry.push_back(pose);
            track_.motions.push_back(lost || i == 0 ? MotionSource::Nothing : MotionSource::Vision);
            track_.features.push_back(lost ? while_lost : types::FrameFeatures{300, 290});
            if (i % 10 == 0 && !lost) track_.keyframes.push_back({i, pose.timestamp_ns});
        }
        track_.causal = track_.odometry;
        track_.breaks_ns = breaks_of(track_);
        track_.statistics.num_frames = 100;
        track_.statistics.num_frames_tracked = 100 - (last_lost - first_lost + 1);
    }

    types::Track track_;
};

TEST_F(TrackingFindingsTest, ADiveThatNeverLosesTheSceneHasNone) {
    swim(0.1, 100, 99, {});
    EXPECT_TRUE(tracking_findings(track_).empty());
    EXPECT_FALSE(too_little_tracked(track_));
}

TEST_F(TrackingFindingsTest, ALossIsToldWithItsFramesSecondsAndShare) {
    swim(0.1, 41, 70, {5, 5});
    const auto findings = tracking_findings(track_);
    ASSERT_EQ(findings.size(), 2U);
    EXPECT_EQ(findings[0].severity, Severity::Warning);
    EXPECT_NE(findings[0].message.find("29 of 100 frames (29.0 %)"), std::string::npos)
        << findings[0].message;
    EXPECT_EQ(findings[1].where, "frames 41 to 70");
    EXPECT_NE(findings[1].message.find("lost for 15.0 s"), std::string::npos)
        << findings[1].message;
    EXPECT_EQ(verdict_on(findings), Verdict::UsableWithRestrictions);
}

TEST_F(TrackingFindingsTest, AFewFramesAreForInformation) {
    swim(0.1, 41, 44, {5, 5});
    EXPECT_EQ(tracking_findings(track_).at(0).severity, Severity::Info);
}

TEST_F(TrackingFindingsTest, ImagesWithoutTextureAreACause) {
    swim(0.1, 41, 70, {5, 5});
    EXPECT_NE(tracking_findings(track_).at(1).message.find("hardly any texture (5 features"),
              std::string::npos);
}

TEST_F(TrackingFindingsTest, FeaturesWithoutARightImageAreACause) {
    swim(0.1, 41, 70, {300, 30});
    const Finding finding = tracking_findings(track_).at(1);
    EXPECT_NE(finding.message.find("only 10 %"), std::string::npos) << finding.message;
    EXPECT_NE(finding.remedy.find("validate"), std::string::npos);
}

// 2 m in 0.5 s at a depth of 2 m are 500 of 640 px: an overlap of 22 % (one in twelve columns is
// 8 %). 60 % are seen again at 256 px, i.e. at 4 pairs a second instead of 2.
TEST_F(TrackingFindingsTest, TooLittleOverlapIsACauseAndTheRemedyIsARate) {
    swim(2.0, 41, 70, {300, 290});
    const Finding finding = tracking_findings(track_).at(1);
    EXPECT_NE(finding.message.find("consecutive images overlap by only 25 %"), std::string::npos)
        << finding.message;
    EXPECT_NE(finding.remedy.find("above 4 pairs a second"), std::string::npos) << finding.remedy;
}

TEST_F(TrackingFindingsTest, LessThanATenthByVisionIsNoModel) {
    swim(0.1, 1, 95, {300, 290});
    const auto finding = too_little_tracked(track_);
    ASSERT_TRUE(finding);
    EXPECT_EQ(finding->severity, Severity::Error);
    EXPECT_NE(finding->message.find("95 of 99 motions"), std::string::npos) << finding->message;
    track_.statistics = {};
    track_.statistics.num_frames = track_.statistics.num_frames_tracked = 1;
    EXPECT_FALSE(too_little_tracked(track_));
}

// The right camera hung after 100 of 1000 pairs: the recorder wrote its last image on.
TEST_F(TrackingFindingsTest, PairsThatCouldNotBeUsedAreMissedByTheirTime) {
    swim(0.1, 100, 99, {});
    track_.unusable = {{100, 50, 100, 25.0}};
    auto findings = tracking_findings(track_);
    ASSERT_EQ(findings.size(), 1U);
    EXPECT_EQ(findings[0].code, "images_unusable");
    EXPECT_EQ(findings[0].severity, Severity::Warning);
    EXPECT_EQ(findings[0].where, "pairs 100 to 149");
    EXPECT_NE(findings[0].message.find("50 of 150 pairs"), std::string::npos)
        << findings[0].message;
    EXPECT_EQ(verdict_on(findings), Verdict::UsableWithRestrictions);
    EXPECT_FALSE(too_little_tracked(track_));

    track_.unusable = {{100, 900, 100, 450.0}};
    const auto failed = too_little_tracked(track_);
    ASSERT_TRUE(failed);
    EXPECT_NE(failed->message.find("900 of 1000 pairs"), std::string::npos) << failed->message;
}

TEST_F(TrackingFindingsTest, ACameraThatRepeatsItsImagesIsOnlySlower) {
    swim(0.1, 100, 99, {});
    for (int i = 1; i < 100; ++i) track_.unusable.push_back({3 * i - 2, 2, i, 0.75});
    EXPECT_TRUE(tracking_findings(track_).empty());
    EXPECT_FALSE(too_little_tracked(track_));
}

// At one pair a second every second one is missing; one pair after a pause is broken.
TEST_F(TrackingFindingsTest, SinglePairsOfASlowCameraAndAPauseAreNotMissed) {
    swim(0.1, 100, 99, {});
    for (std::size_t i = 0; i < track_.odometry.size(); ++i)
        track_.odometry[i].timestamp_ns = 2'000'000'000LL * static_cast<std::int64_t>(i);
    for (int i = 1; i < 100; ++i) track_.unusable.push_back({2 * i - 1, 1, i, 2.0});
    track_.unusable[50].duration_s = 60.0;
    EXPECT_TRUE(tracking_findings(track_).empty());
    EXPECT_FALSE(too_little_tracked(track_));
}

TEST_F(TrackingFindingsTest, OneUsablePairOfManyIsNoModel) {
    track_.statistics.num_frames = track_.statistics.num_frames_tracked = 1;
    track_.odometry.resize(1);
    track_.unusable = {{1, 99, 1, 0.0}};
    EXPECT_TRUE(too_little_tracked(track_));
    track_.statistics = {};
    track_.odometry.clear();
    track_.unusable = {{0, 100, 0, 0.0}};
    EXPECT_TRUE(too_little_tracked(track_));
}

TEST_F(TrackingFindingsTest, MotionsThatTheImuBridgedAllAreNoModelEither) {
    swim(0.1, 1, 98, {300, 290});
    for (int i = 1; i < 99; ++i) track_.motions[static_cast<std::size_t>(i)] = MotionSource::Imu;
    track_.breaks_ns = breaks_of(track_);
    ASSERT_TRUE(track_.breaks_ns.empty());
    const auto failed = too_little_tracked(track_);
    ASSERT_TRUE(failed);
    EXPECT_FALSE(failed->message.empty());
}

}  // namespace
}  // namespace divemesh::pipeline
