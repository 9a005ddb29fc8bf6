#include "worker/evaluation/expected_accuracy.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/synthetic/sensor_recording.hpp"

namespace divemesh::evaluation {
namespace {

struct Known {
    Known() : trajectory(20), covariances(20) {
        for (std::size_t i = 0; i < trajectory.size(); ++i) {
            trajectory[i].timestamp_ns = 100'000'000 * static_cast<std::int64_t>(i);
            trajectory[i].T_world_imu.translation().x() = static_cast<double>(i);
        }
        covariances.back().position_m2 = 1e-4 * Eigen::Matrix3d::Identity();
        optimise.path = {1e-4, 3.0};
        optimise.reprojection_rms_px = 0.3;
    }
    ExpectedAccuracy expected(std::size_t num_segments = 1,
                              const KnownDistanceErrors* known_distances = nullptr) const {
        const ScaleSources scale =
            scale_sources({.known_distances = known_distances, .num_segments = num_segments},
                          trajectory,
                          optimise.path,
                          optimise.loops);
        types::OptimiseStatistics stated = optimise;
        stated.path.scale_contradiction = scale_contradiction(scale.usable, optimise.path);
        return expected_accuracy({.recording = recording,
                                  .trajectory = trajectory,
                                  .num_segments = num_segments,
                                  .path_length_m = 19.0,
                                  .covariances = covariances,
                                  .track = track,
                                  .optimise = stated,
                                  .scale = scale});
    }

    synthetic::SensorRecording recording;
    types::Trajectory trajectory;
    types::CovarianceTrack covariances;
    types::TrackStatistics track;
    types::OptimiseStatistics optimise;
};

bool left_out(const ExpectedAccuracy& expected, const std::string& metric) {
    return std::any_of(expected.left_out.begin(), expected.left_out.end(), [&](const auto& left) {
        return left.metric == metric && !left.reason.empty();
    });
}

TEST(ExpectedAccuracyTest, BoundsTheEndByItsCovariance) {
    const ExpectedAccuracy expected = Known().expected();
    ASSERT_TRUE(expected.end_bound_m.has_value());
    EXPECT_NEAR(*expected.end_bound_m, std::sqrt(7.814728e-4), 1e-8);
    EXPECT_TRUE(left_out(expected, "trajectory.loops"));
}

TEST(ExpectedAccuracyTest, LeavesOutUnknownValuesWithTheirReason) {
    Known known;
    known.covariances.clear();
    const nlohmann::json metrics = to_metrics(known.expected());
    EXPECT_FALSE(metrics.contains("trajectory"));
    EXPECT_FALSE(metrics.contains("scale"));
    EXPECT_FALSE(metrics.contains("surface"));
    EXPECT_FALSE(metrics.contains("imu_vision_disagreement_deg"));
    for (const char* metric :
         {"trajectory.ate", "scale.accelerometer", "scale.pressure", "surface"})
        EXPECT_TRUE(left_out(known.expected(), metric)) << metric;
}

// The path is straight and 19 m long. If the bars are right, all of it is 9 % shorter.
TEST(ExpectedAccuracyTest, BoundsCoverASensorThatContradictsTheCameras) {
    Known known;
    known.optimise.path.scale_sigma = 0.002;
    known.optimise.path.spread_m2 = (20.0 * 20.0 - 1.0) / 12.0;
    EXPECT_NEAR(known.expected().cameras.value().sigma, 0.002, 1e-12);
    KnownDistanceErrors bars;
    for (int i = 0; i < 4; ++i) bars.distances.push_back({"bar", 1.0, 1.1, {}, 4, 4});
    bars.num_measured = 4;
    bars.scale_error = 0.1;
    const ExpectedAccuracy contradicted = known.expected(1, &bars);
    const double off = 1.0 - 1.0 / 1.1;
    EXPECT_NEAR(contradicted.cameras.value().sigma, std::hypot(0.002, off / 1.959963984540), 1e-9);
    const double ate_m = off * std::sqrt(known.optimise.path.spread_m2);
    EXPECT_GT(contradicted.ate_bound_m.value(), ate_m);
    EXPECT_LT(contradicted.ate_bound_m.value(), 1.01 * ate_m);
    EXPECT_GT(contradicted.end_bound_m.value(), off * 19.0);
    EXPECT_LT(contradicted.end_bound_m.value(), 1.01 * off * 19.0);
    // Volumes contain it as an error of scale.
    EXPECT_EQ(contradicted.surface_shared_m.value(), known.expected().surface_shared_m.value());
}

TEST(ExpectedAccuracyTest, StatesNoDriftForDisconnectedSegments) {
    EXPECT_FALSE(Known().expected(2).end_bound_m.has_value());
}

TEST(ExpectedAccuracyTest, LoopResidualsWidenTheBounds) {
    Known known;
    const double before = *known.expected().end_bound_m;
    known.optimise.loops.num_accepted = 1;
    known.optimise.loops.residual_m = 0.02;
    known.optimise.loops.residual_sigmas = 2.0;
    EXPECT_NEAR(*known.expected().end_bound_m, 2.0 * before, 1e-9);
    known.optimise.loops.residual_sigmas = 0.5;
    EXPECT_NEAR(*known.expected().end_bound_m, before, 1e-9);
}

TEST(ExpectedAccuracyTest, ALargeBoundAndAContradictedScaleAreFindings) {
    Known known;
    known.covariances.back().position_m2 = Eigen::Matrix3d::Identity();
    known.optimise.path.mean_square_m2 = 0.3;
    EXPECT_EQ(known.expected().findings.at(0).code, "drift_may_be_large");

    known.optimise.path.mean_square_m2 = 1e-4;
    KnownDistanceErrors distances;
    for (const auto& [known_m, measured_m] : {std::pair(1.0, 0.951), {1.0, 0.949}, {2.0, 1.9}})
        distances.distances.push_back({"", known_m, measured_m, 4, 4});
    distances.num_measured = 3;
    distances.scale_error = -0.05;
    known.covariances.clear();
    const ExpectedAccuracy expected = known.expected(1, &distances);
    ASSERT_EQ(expected.findings.size(), 1U);
    EXPECT_EQ(expected.findings[0].code, "scale_contradicted");
    EXPECT_NE(expected.findings[0].message.find("5.3 % longer"), std::string::npos);
}

}  // namespace
}  // namespace divemesh::evaluation
