#include "worker/odometry/rest_detector.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>
#include <vector>

#include "worker/base/rotation_vector.hpp"
#include "worker/base/seconds.hpp"
#include "worker/odometry/refine_pose.hpp"
#include "worker/stats/distributions.hpp"
#include "worker/stats/median.hpp"
#include "worker/stats/robust.hpp"

namespace divemesh::odometry {
namespace {

constexpr std::int64_t kMinRest_ns = 1'000'000'000;
constexpr std::size_t kMinNumPairs = 30;
constexpr std::size_t kMinNumPairsAtRest = 6;  // once the rig rests
constexpr std::int64_t kMaxUnseen_ns = 2'000'000'000;
constexpr double kMoved_px = 1.0;         // median shift since the anchor
constexpr double kMinShareInPlace = 0.2;  // of all near features
constexpr double kNear_m = 0.02;          // a motion by so much moves a near feature by a pixel
constexpr double kConfidence = 0.99;      // beyond which a motion is significant
// The noise of features that stay in place is measured, as a share of the usual noise. Below this
// share, errors that all features have in common (light, compression) prevail.
constexpr double kMinNoise = 0.2;
constexpr double kMaxScatter = 1.0;  // so that no rest hides more than the noise of a single pose
constexpr std::int64_t kScatterTime_ns = 5'000'000'000;
constexpr std::int64_t kNotYetScatter_ns = 1'000'000'000;  // the beginning of a motion is none
constexpr double kMinSigma_m = 1e-5;
constexpr double kMinSigma_rad = 1e-6;
constexpr Eigen::Index kMinNumMotions = 5;

// Returns the noise of a pixel difference after the motion, in sigmas as assumed.
double noise_of(const types::RectifiedRig& rig,
                const PointPairs& pairs,
                const Eigen::Isometry3d& T_current_previous) {
    std::vector<double> errors;
    for (const PointPair& pair : pairs) {
        const Eigen::Vector3d error =
            types::project_px(rig, T_current_previous * pair.p_previous) - pair.current_px;
        for (int axis = 0; axis < 2; ++axis)
            errors.push_back(std::abs(error[axis]) /
                             (std::sqrt(2.0) * types::kFeatureSigma_px[axis]));
    }
    return std::max(kMinNoise, stats::kSigmasPerMad * stats::upper_median(std::move(errors)));
}

// The pairs that a motion explains, and the robust loss of all.
struct Explained {
    PointPairs pairs;
    double loss = 0.0;
};

// `noise` is that of a pixel difference, in sigmas as assumed.
Explained explained(const types::RectifiedRig& rig,
                    const PointPairs& pairs,
                    const Eigen::Isometry3d& T_current_previous,
                    double noise) {
    Explained result;
    for (const PointPair& pair : pairs) {
        const Eigen::Vector3d error =
            types::project_px(rig, T_current_previous * pair.p_previous) - pair.current_px;
        const Eigen::Array2d sigmas =
            error.head<2>().array() /
            (std::sqrt(2.0) * noise * types::kFeatureSigma_px.head<2>().array());
        if (sigmas.abs().maxCoeff() < stats::kTukey) result.pairs.push_back(pair);
        result.loss += stats::tukey_loss(sigmas.matrix().norm(), stats::kTukey);
    }
    return result;
}

double largest_sigma(const Eigen::Matrix3d& covariance) {
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(covariance, Eigen::EigenvaluesOnly);
    return std::sqrt(std::max(0.0, solver.eigenvalues()[2]));
}

}  // namespace

double median_shift_px(const PointPairs& pairs) {
    if (pairs.empty()) return 0.0;
    std::vector<double> shifts_px;
    shifts_px.reserve(pairs.size());
    for (const PointPair& pair : pairs)
        shifts_px.push_back((pair.current_px - pair.previous_px).head<2>().norm());
    return stats::upper_median(std::move(shifts_px));
}

std::optional<Eigen::Isometry3d> RestDetector::watch(std::int64_t now_ns,
                                                     const types::Features& features,
                                                     const Eigen::Isometry3d& T_world_cam,
                                                     Seen seen) {
    if (now_ns - last_ns_ > kMaxUnseen_ns) restart();
    last_ns_ = now_ns;
    pass_frame();
    PointPairs pairs = with_depth_at_both_times(rig_, anchor_, features);
    if (seen == Seen::AllFeaturesAtRest) pairs = in_place(pairs);
    hardly_moves_ = hardly_moved(pairs);
    if (!hardly_moves_) {
        anchor_ = features;
        anchor_ns_ = now_ns;
        motions_.clear();
        T_world_anchor_ = T_world_cam;
        return std::nullopt;
    }
    const auto motion = significant_motion(now_ns, agreeing(pairs));
    if (!motion) {
        restart();
        return std::nullopt;
    }
    T_anchor_cam_ = motion;
    join(features);
    at_rest_ = now_ns - anchor_ns_ >= kMinRest_ns;
    if (!at_rest_) return std::nullopt;
    return T_world_anchor_ * *motion;
}

void RestDetector::correct(const Eigen::Isometry3d& T_world_cam) {
    if (T_anchor_cam_)
        T_world_anchor_ = T_world_cam * T_anchor_cam_->inverse();
    else if (anchor_ns_ == last_ns_)
        T_world_anchor_ = T_world_cam;
    else
        restart();
}

// Returns the near pairs that have kept their places; none if they are few among the near ones.
PointPairs RestDetector::in_place(const PointPairs& pairs) const {
    PointPairs kept;
    std::size_t num_near = 0;
    for (const PointPair& pair : pairs) {
        if (pair.p_previous.z() > kNear_m * rig_.focal_px) continue;
        ++num_near;
        if ((pair.current_px - pair.previous_px).head<2>().norm() < kMoved_px) kept.push_back(pair);
    }
    if (static_cast<double>(kept.size()) < kMinShareInPlace * static_cast<double>(num_near))
        kept.clear();
    return kept;
}

void RestDetector::join(const types::Features& in_last_frame) {
    if (!T_anchor_cam_ || !T_anchor_cam_->matrix().isIdentity()) return;
    types::Features all;
    std::set_union(anchor_.begin(),
                   anchor_.end(),
                   in_last_frame.begin(),
                   in_last_frame.end(),
                   std::back_inserter(all),
                   [](const types::Feature& a, const types::Feature& b) { return a.id < b.id; });
    anchor_ = std::move(all);
}

bool RestDetector::hardly_moved(const PointPairs& pairs) const {
    return pairs.size() >= (hardly_moves_ ? kMinNumPairsAtRest : kMinNumPairs) &&
           median_shift_px(pairs) < kMoved_px;
}

// Returns the pairs that stay in place together, or those that move together if that explains more;
// all if too few agree.
PointPairs RestDetector::agreeing(const PointPairs& pairs) const {
    const Eigen::Isometry3d at_rest = Eigen::Isometry3d::Identity();
    const Eigen::Isometry3d moved =
        refine_pose(rig_, pairs, {at_rest, std::nullopt, 0.0}).T_current_previous;
    const double noise = std::min(noise_of(rig_, pairs, at_rest), noise_of(rig_, pairs, moved));
    Explained in_place = explained(rig_, pairs, at_rest, noise);
    Explained in_motion = explained(rig_, pairs, moved, noise);
    Explained& best = in_place.loss <= in_motion.loss ? in_place : in_motion;
    if (best.pairs.size() < kMinNumPairsAtRest) return pairs;
    return std::move(best.pairs);
}

// Returns the standard deviation of the motions up to a time about their linear trend, in units of
// that of a single one, along the direction where it is largest; 0 if there are too few.
double RestDetector::scatter_of_motions(std::int64_t until_ns, const Matrix6d& covariance) const {
    const auto end = std::ranges::upper_bound(motions_, until_ns, {}, &Motion::time_ns);
    const auto num = static_cast<Eigen::Index>(end - motions_.begin());
    if (num < kMinNumMotions) return 0.0;
    Eigen::MatrixX2d times(num, 2);
    Eigen::Matrix<double, Eigen::Dynamic, 6> values(num, 6);
    for (Eigen::Index i = 0; i < num; ++i) {
        const Motion& motion = motions_[static_cast<std::size_t>(i)];
        times.row(i) << 1.0, base::to_s(motion.time_ns - motions_.front().time_ns);
        values.row(i) = motion.since_anchor.transpose();
    }
    const Eigen::Matrix<double, 2, 6> trend =
        (times.transpose() * times).ldlt().solve(times.transpose() * values);
    const Eigen::Matrix<double, 6, Eigen::Dynamic> residuals = (values - times * trend).transpose();
    const Eigen::LLT<Matrix6d> factor(covariance);
    const Eigen::Matrix<double, 6, Eigen::Dynamic> in_sigmas = factor.matrixL().solve(residuals);
    const Matrix6d scatter = in_sigmas * in_sigmas.transpose() / static_cast<double>(num - 2);
    const Eigen::SelfAdjointEigenSolver<Matrix6d> solver(scatter, Eigen::EigenvaluesOnly);
    return std::sqrt(std::max(0.0, solver.eigenvalues()[5]));
}

// Returns T_anchor_cam: the identity if noise explains the motion, a rotation if noise explains its
// translation; nullopt if the solver failed.
std::optional<Eigen::Isometry3d> RestDetector::significant_motion(std::int64_t now_ns,
                                                                  const PointPairs& pairs) {
    const RefinedPose refined =
        refine_pose(rig_, pairs, {Eigen::Isometry3d::Identity(), std::nullopt, 0.0});
    if (refined.outcome.failed()) return std::nullopt;
    const Eigen::Isometry3d& T_cam_anchor = refined.T_current_previous;
    const Eigen::Vector3d turned =
        base::vector_from_rotation(Eigen::Quaterniond(T_cam_anchor.linear()));
    const Eigen::Vector3d moved = T_cam_anchor.translation();
    Vector6d motion;
    motion << turned, moved;
    const Matrix6d covariance = motion_covariance(rig_, pairs, {T_cam_anchor, std::nullopt, 0.0});
    motions_.push_back({now_ns, motion});
    while (now_ns - motions_.front().time_ns > kScatterTime_ns) motions_.pop_front();
    const double noise =
        std::max(noise_of(rig_, pairs, T_cam_anchor),
                 std::min(kMaxScatter, scatter_of_motions(now_ns - kNotYetScatter_ns, covariance)));
    sigma_rad_ = std::max(kMinSigma_rad, noise * largest_sigma(covariance.topLeftCorner<3, 3>()));
    sigma_m_ = std::max(kMinSigma_m, noise * largest_sigma(covariance.bottomRightCorner<3, 3>()));
    static const double kMaxOfSix = stats::chi_square_quantile(kConfidence, 6.0);
    static const double kMaxOfThree = stats::chi_square_quantile(kConfidence, 3.0);
    if (motion.dot(covariance.ldlt().solve(motion)) < kMaxOfSix * noise * noise)
        return Eigen::Isometry3d::Identity();
    const Eigen::Vector3d weighted = covariance.bottomRightCorner<3, 3>().ldlt().solve(moved);
    if (moved.dot(weighted) > kMaxOfThree * noise * noise) return T_cam_anchor.inverse();
    Eigen::Isometry3d T_anchor_cam = Eigen::Isometry3d::Identity();
    T_anchor_cam.linear() =
        base::rotation_from_vector(covariance.topRightCorner<3, 3>() * weighted - turned)
            .toRotationMatrix();
    return T_anchor_cam;
}

}  // namespace divemesh::odometry
