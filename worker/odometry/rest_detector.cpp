#include "worker/odometry/rest_detector.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>
#include <vector>

#include "worker/base/rotation_vector.hpp"
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

double median_shift_px(const PointPairs& pairs) {
    std::vector<double> shifts_px;
    shifts_px.reserve(pairs.size());
    for (const PointPair& pair : pairs)
        shifts_px.push_back((pair.current_px - pair.previous_px).head<2>().norm());
    return stats::upper_median(std::move(shifts_px));
}

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

double largest_sigma(const Eigen::Matrix3d& covariance) {
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(covariance, Eigen::EigenvaluesOnly);
    return std::sqrt(std::max(0.0, solver.eigenvalues()[2]));
}

}  // namespace

std::optional<Eigen::Isometry3d> RestDetector::watch(std::int64_t now_ns,
                                                     const types::Features& features,
                                                     const Eigen::Isometry3d& T_world_cam,
                                                     Seen seen) {
    if (now_ns - last_ns_ > kMaxUnseen_ns) restart();
    last_ns_ = now_ns;
    PointPairs pairs = with_depth_at_both_times(rig_, anchor_, features);
    if (seen == Seen::AllFeaturesAtRest) pairs = in_place(pairs);
    hardly_moves_ = hardly_moved(pairs);
    if (!hardly_moves_) {
        anchor_ = features;
        anchor_ns_ = now_ns;
        T_world_anchor_ = T_world_cam;
        return std::nullopt;
    }
    if (now_ns - anchor_ns_ < kMinRest_ns) return std::nullopt;
    const auto motion = significant_motion(pairs);
    if (!motion) {
        restart();
        return std::nullopt;
    }
    T_anchor_cam_ = *motion;
    if (T_anchor_cam_.matrix().isIdentity()) join_anchor(features);
    return T_world_anchor_ * T_anchor_cam_;
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

void RestDetector::join_anchor(const types::Features& features) {
    types::Features all;
    std::set_union(anchor_.begin(),
                   anchor_.end(),
                   features.begin(),
                   features.end(),
                   std::back_inserter(all),
                   [](const types::Feature& a, const types::Feature& b) { return a.id < b.id; });
    anchor_ = std::move(all);
}

bool RestDetector::hardly_moved(const PointPairs& pairs) const {
    return pairs.size() >= (hardly_moves_ ? kMinNumPairsAtRest : kMinNumPairs) &&
           median_shift_px(pairs) < kMoved_px;
}

// Returns T_anchor_cam: the identity if noise explains the motion, a rotation if noise explains its
// translation; nullopt if the solver failed.
std::optional<Eigen::Isometry3d> RestDetector::significant_motion(const PointPairs& pairs) {
    const RefinedPose refined =
        refine_pose(rig_, pairs, {Eigen::Isometry3d::Identity(), std::nullopt, 0.0});
    if (refined.outcome.failed()) return std::nullopt;
    const Eigen::Isometry3d& T_cam_anchor = refined.T_current_previous;
    const Eigen::Vector3d turned =
        base::vector_from_rotation(Eigen::Quaterniond(T_cam_anchor.linear()));
    const Eigen::Vector3d moved = T_cam_anchor.translation();
    Eigen::Matrix<double, 6, 1> motion;
    motion << turned, moved;
    const Eigen::Matrix<double, 6, 6> covariance =
        motion_covariance(rig_, pairs, {T_cam_anchor, std::nullopt, 0.0});
    const double noise = noise_of(rig_, pairs, T_cam_anchor);
    sigma_rad_ = noise * largest_sigma(covariance.topLeftCorner<3, 3>());
    sigma_m_ = noise * largest_sigma(covariance.bottomRightCorner<3, 3>());
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
