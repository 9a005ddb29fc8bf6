#include "sensor/quick_odometry.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "worker/estimation/frame_features.hpp"
#include "worker/steps/match_features.hpp"
#include "worker/steps/refine_pose.hpp"
#include "worker/steps/register_with_turn.hpp"

namespace divemesh::sensor {
namespace {

using namespace divemesh::worker;

constexpr double kTolerance_px = 2.0;
constexpr double kLongestGap_s = 3.0;  // for which a speed is believed
constexpr int kNumDisparities_px = 128;
constexpr int kNumFeatures = 200;

ReconstructionOptions options() {
    ReconstructionOptions options;
    options.num_features = kNumFeatures;
    return options;
}

// Of translation and rotation of the camera as these pairs measure it: m^2, rad^2, the larger sums
// of the two blocks' diagonals.
struct StepVariance {
    double position_m2 = 0.0;
    double heading_rad2 = 0.0;
};

// By the information of (u, v, disparity) at each pair's point p, which moves with t + w x p.
StepVariance variance_of(const RectifiedRig& rig, const PointPairs& pairs) {
    Eigen::Matrix<double, 6, 6> information = Eigen::Matrix<double, 6, 6>::Zero();
    for (const PointPair& pair : pairs) {
        const Eigen::Vector3d& p = pair.p_current;
        if (p.z() < 1e-3) continue;
        const double f = rig.focal_px / p.z();
        Eigen::Matrix3d by_point;
        by_point << f, 0.0, -f * p.x() / p.z(), 0.0, f, -f * p.y() / p.z(), 0.0, 0.0,
            -f * rig.baseline_m / p.z();
        Eigen::Matrix3d cross;
        cross << 0.0, p.z(), -p.y(), -p.z(), 0.0, p.x(), p.y(), -p.x(), 0.0;
        Eigen::Matrix<double, 3, 6> J;
        J << by_point, by_point * cross;
        const Eigen::Vector3d variance =
            pair.current_sigma_px.cwiseAbs2() + pair.previous_sigma_px.cwiseAbs2();
        information += J.transpose() * variance.cwiseInverse().asDiagonal() * J;
    }
    const Eigen::Matrix<double, 6, 6> covariance =
        information.ldlt().solve(Eigen::Matrix<double, 6, 6>::Identity());
    return {covariance.topLeftCorner<3, 3>().trace(), covariance.bottomRightCorner<3, 3>().trace()};
}

}  // namespace

QuickOdometry::QuickOdometry(const Rig& rig)
    : rectifier_(rig), tracker_(rectifier_.rig(), options()) {}

Eigen::Isometry3d QuickOdometry::expected(double interval_s) const {
    Eigen::Isometry3d T_current_previous = Eigen::Isometry3d::Identity();
    const Eigen::Vector3d turn = turn_rate_cam_ * interval_s;
    if (turn.norm() > 1e-9)
        T_current_previous.linear() =
            Eigen::AngleAxisd(turn.norm(), turn.normalized()).toRotationMatrix();
    T_current_previous.translation() = velocity_cam_ * interval_s;
    return T_current_previous;
}

void QuickOdometry::add(const StereoFrame& before, const StereoFrame& now) {
    const double interval_s = static_cast<double>(now.timestamp_ns - before.timestamp_ns) * 1e-9;
    if (!(interval_s > 0.0)) return;
    const RectifiedRig& rig = rectifier_.rig();
    const RectifiedFrame first = rectifier_.rectify(before);
    tracker_.track(first.left, {}, Eigen::Isometry3d::Identity());
    Features features;
    add_new_features(rig, first, {}, kNumDisparities_px, tracker_, features);
    const RectifiedFrame frame = rectifier_.rectify(now);
    const Eigen::Isometry3d guess = expected(interval_s);
    features_ = tracker_.track(frame.left, features, guess);
    match_features(frame, {}, kNumDisparities_px, features_);
    const PointPairs pairs = with_depth_at_both_times(rig, features, features_);
    picture_ = frame.left;
    show(pairs);
    const auto seed = static_cast<std::uint64_t>(num_pairs_++);
    const Registration motion =
        register_with_turn(rig, pairs, std::nullopt, guess, kTolerance_px, seed);
    const double since_s = static_cast<double>(now.timestamp_ns - last_ns_) * 1e-9;
    if (!motion.found) {
        ++num_lost_;
        return;
    }
    last_ns_ = now.timestamp_ns;
    const bool goes_on = since_s > 0.0 && since_s < kLongestGap_s;
    advance(refine_pose(rig, motion.inliers, {motion.T_current_previous, {}, 0.0}),
            motion.inliers,
            interval_s,
            goes_on ? since_s / interval_s : 1.0);
}

void QuickOdometry::show(const PointPairs& pairs) {
    tracks_.clear();
    for (const PointPair& pair : pairs)
        tracks_.push_back(
            {{static_cast<float>(pair.previous_px.x()), static_cast<float>(pair.previous_px.y())},
             {static_cast<float>(pair.current_px.x()), static_cast<float>(pair.current_px.y())}});
}

void QuickOdometry::advance(const Eigen::Isometry3d& T_current_previous,
                            const PointPairs& pairs,
                            double interval_s,
                            double num_steps) {
    const double step_m = T_current_previous.translation().norm();
    const StepVariance variance = variance_of(rectifier_.rig(), pairs);
    // Standing still, noise alone would add up to a way.
    if (step_m * step_m > 4.0 * variance.position_m2) distance_m_ += num_steps * step_m;
    heading_drift_m_ += num_steps * step_m * std::sqrt(heading_variance_rad2_);
    position_variance_m2_ += num_steps * variance.position_m2;
    heading_variance_rad2_ += num_steps * variance.heading_rad2;
    const Eigen::AngleAxisd turn(T_current_previous.linear());
    turn_rate_cam_ = turn.axis() * turn.angle() / interval_s;
    velocity_cam_ = T_current_previous.translation() / interval_s;
}

double QuickOdometry::expected_drift_m() const {
    return std::sqrt(position_variance_m2_ + heading_drift_m_ * heading_drift_m_);
}

}  // namespace divemesh::sensor
