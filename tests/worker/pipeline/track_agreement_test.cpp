#include "worker/pipeline/track_agreement.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "tests/synthetic/tracked_dive.hpp"

namespace divemesh::pipeline {
namespace {

class TrackAgreementTest : public testing::Test {
protected:
    types::TrackCheck check() const {
        return {agreement(tracked_, tracked_, 1, drift_), agreement(now_, tracked_, 1, drift_)};
    }

    const types::Track tracked_ = synthetic::tracked_dive(20);
    const loops::DriftModel drift_{tracked_.keyframes, tracked_.landmarks, nullptr};
    types::Track now_ = tracked_;
};

TEST_F(TrackAgreementTest, OfATrueTrackIsThatOfItsNoise) {
    const types::TrackAgreement of = agreement(tracked_, tracked_, 1, drift_);
    EXPECT_TRUE(of.finite);
    EXPECT_GT(of.reprojection_rms_px, 0.2);
    EXPECT_LT(of.reprojection_rms_px, 0.8);
    EXPECT_LT(of.odometry_rms_sigmas, 1e-6);
}

TEST_F(TrackAgreementTest, AMovedWorldIsNoWorse) {
    Eigen::Isometry3d T_new_old = Eigen::Isometry3d::Identity();
    T_new_old.translate(Eigen::Vector3d(5.0, -2.0, 1.0));
    T_new_old.rotate(Eigen::AngleAxisd(0.7, Eigen::Vector3d::UnitZ()));
    for (types::Keyframe& keyframe : now_.keyframes)
        keyframe.T_world_cam = T_new_old * keyframe.T_world_cam;
    for (types::Landmark& landmark : now_.landmarks)
        landmark.p_world = T_new_old * landmark.p_world;
    EXPECT_FALSE(is_worse(check()));
}

TEST_F(TrackAgreementTest, ObservationsThatLoopsAddedDoNotCount) {
    for (types::Landmark& landmark : now_.landmarks)
        landmark.observations.push_back({0, 0.0F, 0.0F});
    EXPECT_DOUBLE_EQ(check().after.reprojection_rms_px, check().before.reprojection_rms_px);
}

TEST_F(TrackAgreementTest, KeyframesTornApartContradictTheOdometry) {
    for (std::size_t k = 10; k < now_.keyframes.size(); ++k)
        now_.keyframes[k].T_world_cam.translation().x() += 0.4;
    for (types::Landmark& landmark : now_.landmarks)
        if (landmark.observations.front().keyframe >= 10) landmark.p_world.x() += 0.4;
    EXPECT_TRUE(contradicts_odometry(check()));
    EXPECT_TRUE(is_worse(check()));
}

TEST_F(TrackAgreementTest, LandmarksThatNoLongerProjectToWhereTheyWereSeenAreWorse) {
    for (types::Landmark& landmark : now_.landmarks) landmark.p_world.z() += 0.2;
    EXPECT_FALSE(contradicts_odometry(check()));
    EXPECT_TRUE(is_worse(check()));
}

TEST_F(TrackAgreementTest, WhatIsNotANumberIsWorse) {
    now_.landmarks.front().p_world.x() = std::numeric_limits<double>::quiet_NaN();
    EXPECT_TRUE(is_worse(check()));
}

TEST_F(TrackAgreementTest, AMoveIsMeasuredInSigmasOfBothPaths) {
    const types::CovarianceTrack covariances = {{0, {}, {}},
                                                {now_.keyframes.back().timestamp_ns,
                                                 1e-6 * Eigen::Matrix3d::Identity(),
                                                 Eigen::Matrix3d::Zero()}};
    EXPECT_LT(moved_rms_sigmas(tracked_.keyframes, now_.keyframes, covariances, drift_), 1e-9);
    for (std::size_t k = 1; k < now_.keyframes.size(); ++k)
        now_.keyframes[k].T_world_cam.translation().y() += drift_.position_sigma_m(0, k);
    EXPECT_NEAR(
        moved_rms_sigmas(tracked_.keyframes, now_.keyframes, covariances, drift_), 1.0, 0.01);
}

TEST_F(TrackAgreementTest, WithoutACovarianceAMoveIsMeasuredInSigmasOfTheDrift) {
    for (std::size_t k = 1; k < now_.keyframes.size(); ++k)
        now_.keyframes[k].T_world_cam.translation().y() += 2.0 * drift_.position_sigma_m(0, k);
    EXPECT_NEAR(moved_rms_sigmas(tracked_.keyframes, now_.keyframes, {}, drift_), 2.0, 1e-9);
}

}  // namespace
}  // namespace divemesh::pipeline
