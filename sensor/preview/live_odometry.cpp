#include "sensor/preview/live_odometry.hpp"

#include <algorithm>
#include <cmath>

#include "worker/base/rotation_vector.hpp"
#include "worker/base/seconds.hpp"
#include "worker/features/match_sparse_stereo.hpp"
#include "worker/odometry/frame_features.hpp"
#include "worker/odometry/refine_pose.hpp"
#include "worker/odometry/register_with_rotation.hpp"

namespace divemesh::sensor {
namespace {

using Vector6d = Eigen::Matrix<double, 6, 1>;

constexpr double kTolerance_px = 2.0;
constexpr double kMaxPrediction_s = 3.0;  // max time for which a speed is extrapolated
constexpr int kNumDisparities_px = 128;
constexpr int kNumFeatures = 200;
constexpr int kMinChanges = 4;    // min number for estimating how the motion varies
constexpr double kUnrest = 0.01;  // used until then: 0.1 m/s, 6 deg/s within a second

double seconds_between(std::int64_t before_ns, std::int64_t after_ns) {
    return base::to_s(after_ns - before_ns);
}

Vector6d vector_of(const Eigen::Isometry3d& T) {
    Vector6d vector;
    vector << base::vector_from_rotation(Eigen::Quaterniond(T.linear())), T.translation();
    return vector;
}

Eigen::Isometry3d motion_of(const Vector6d& vector) {
    Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
    T.linear() = base::rotation_from_vector(vector.head<3>()).toRotationMatrix();
    T.translation() = vector.tail<3>();
    return T;
}

}  // namespace

LiveOdometry::LiveOdometry(const types::Rig& rig)
    : rectifier_(rig), tracker_(rectifier_.rig(), kNumFeatures) {}

void LiveOdometry::add(const types::StereoFrame& before, const types::StereoFrame& now) {
    const double interval_s = seconds_between(before.timestamp_ns, now.timestamp_ns);
    if (!(interval_s > 0.0)) return;
    const bool is_known =
        motion_ && seconds_between(motion_->timestamp_ns, now.timestamp_ns) < kMaxPrediction_s;
    const Eigen::Isometry3d guess =
        is_known ? motion_of(motion_->rate * interval_s) : Eigen::Isometry3d::Identity();
    const odometry::PointPairs pairs = follow(before, now, guess);
    const auto seed = static_cast<std::uint64_t>(num_assessments_++);
    const types::RectifiedRig& rig = rectifier_.rig();
    const odometry::Registration found =
        odometry::register_with_rotation(rig, pairs, std::nullopt, guess, kTolerance_px, seed);
    if (!found.found) {
        ++num_lost_;
        return;
    }
    const auto refined =
        odometry::refine_pose(rig, found.inliers, {found.T_current_previous, {}, 0.0});
    if (refined.outcome.failed()) {
        ++num_lost_;
        return;
    }
    const Eigen::Isometry3d& T_current_previous = refined.T_current_previous;
    const Motion motion{
        now.timestamp_ns,
        vector_of(T_current_previous) / interval_s,
        odometry::motion_covariance(rig, found.inliers, {T_current_previous, {}, 0.0}) /
            (interval_s * interval_s)};
    if (motion_ && motion_->timestamp_ns < motion.timestamp_ns) advance(*motion_, motion);
    motion_before_ = motion_;
    motion_ = motion;
}

odometry::PointPairs LiveOdometry::follow(const types::StereoFrame& before,
                                          const types::StereoFrame& now,
                                          const Eigen::Isometry3d& guess) {
    const types::RectifiedRig& rig = rectifier_.rig();
    const types::RectifiedFrame first = rectifier_.rectify(before);
    tracker_.track(first.left, {}, Eigen::Isometry3d::Identity());
    types::Features features;
    odometry::add_new_features(rig, first, {}, kNumDisparities_px, tracker_, features);
    const types::RectifiedFrame frame = rectifier_.rectify(now);
    features_ = tracker_.track(frame.left, features, guess);
    features::match_sparse_stereo(frame, {}, kNumDisparities_px, features_);
    image_ = frame.left;
    odometry::PointPairs pairs = odometry::with_depth_at_both_times(rig, features, features_);
    show(pairs);
    return pairs;
}

void LiveOdometry::show(const odometry::PointPairs& pairs) {
    tracks_.clear();
    for (const odometry::PointPair& pair : pairs)
        tracks_.push_back(
            {{static_cast<float>(pair.previous_px.x()), static_cast<float>(pair.previous_px.y())},
             {static_cast<float>(pair.current_px.x()), static_cast<float>(pair.current_px.y())}});
}

// The error of an assessment enters the step before it and the step after it, each for half of the
// step. This equals both steps having, independently, the whole mean variance of their assessments.
// Between its ends the rate is a Brownian bridge, if its changes are a random walk of intensity q:
// its integral has the variance q T^3 / 12.
void LiveOdometry::advance(const Motion& from, const Motion& to) {
    const double interval_s = seconds_between(from.timestamp_ns, to.timestamp_ns);
    if (motion_before_) learn_unrest(*motion_before_, from, to);
    const Eigen::Isometry3d T_current_previous =
        motion_of(0.5 * interval_s * (from.rate + to.rate));
    Vector6d intensity = Vector6d::Constant(kUnrest);
    if (num_changes_ >= kMinChanges) intensity = (unrest_ / num_changes_).cwiseMax(0.0);
    Matrix6d covariance = 0.5 * interval_s * interval_s * (from.covariance + to.covariance);
    covariance.diagonal() += std::pow(interval_s, 3) / 12.0 * intensity;
    add_error(T_current_previous, covariance);
    T_first_current_ = T_first_current_ * T_current_previous.inverse();
    distance_m_ += 0.5 * interval_s * (from.speed_m_s() + to.speed_m_s());
}

// Estimates q from the distance of an assessment to the line between the ones before and after it,
// minus its own errors: the variance of a Brownian bridge there is q a b / (a + b).
void LiveOdometry::learn_unrest(const Motion& before, const Motion& middle, const Motion& after) {
    const double a = seconds_between(before.timestamp_ns, middle.timestamp_ns);
    const double b = seconds_between(middle.timestamp_ns, after.timestamp_ns);
    const double share = a / (a + b);
    const Vector6d missed = middle.rate - (1.0 - share) * before.rate - share * after.rate;
    const Vector6d noise = middle.covariance.diagonal() +
                           (1.0 - share) * (1.0 - share) * before.covariance.diagonal() +
                           share * share * after.covariance.diagonal();
    unrest_ += (missed.cwiseAbs2() - noise) / (share * b);
    ++num_changes_;
}

// Uses the translation only and subtracts what noise adds to it: otherwise a camera at rest would
// seem to move.
double LiveOdometry::Motion::speed_m_s() const {
    const double square =
        rate.tail<3>().squaredNorm() - covariance.bottomRightCorner<3, 3>().trace();
    return std::sqrt(std::max(square, 0.0));
}

// With the motion's error (w, e) as motion_covariance() has it, R = exp(w) R and t = t + e, and d
// the step in the first frame: the rotation's error phi becomes phi - R_first w, the position's p +
// phi x d - R_first (e + t x w).
void LiveOdometry::add_error(const Eigen::Isometry3d& T_current_previous,
                             const Matrix6d& covariance) {
    const Eigen::Isometry3d T_first_next = T_first_current_ * T_current_previous.inverse();
    const Eigen::Vector3d step = T_first_next.translation() - T_first_current_.translation();
    const Eigen::Matrix3d R = T_first_next.linear();
    Matrix6d by_before = Matrix6d::Identity();
    by_before.bottomLeftCorner<3, 3>() = -base::cross_matrix(step);
    Matrix6d by_motion = Matrix6d::Zero();
    by_motion.topLeftCorner<3, 3>() = -R;
    by_motion.bottomLeftCorner<3, 3>() = -R * base::cross_matrix(T_current_previous.translation());
    by_motion.bottomRightCorner<3, 3>() = -R;
    covariance_ = by_before * covariance_ * by_before.transpose() +
                  by_motion * covariance * by_motion.transpose();
}

double LiveOdometry::expected_drift_m() const {
    return std::sqrt(covariance_.bottomRightCorner<3, 3>().trace());
}

}  // namespace divemesh::sensor
