#include "worker/odometry/register_with_rotation.hpp"

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "worker/base/horn.hpp"
#include "worker/odometry/pair_inliers.hpp"
#include "worker/odometry/refine_pose.hpp"
#include "worker/stats/num_ransac_iterations.hpp"

namespace divemesh::odometry {
namespace {

// Several iterations at least, as one pair's noise moves the translation.
constexpr stats::RansacLimits kRansac{
    .sample_size = 1, .confidence = 0.9999, .min_iterations = 10, .max_iterations = 60};
constexpr double kMaxSigma_rad = 0.02;    // ten pixels: worse than the prediction
constexpr double kMinTrustedShare = 0.7;  // share of pairs that confirms the known rotation

// Returns the best motion among the expected one and those with the gyroscope's rotation.
Eigen::Isometry3d best_translation(const types::RectifiedRig& rig,
                                   const PointPairs& pairs,
                                   const Eigen::Matrix3d& R_current_previous,
                                   const Eigen::Isometry3d& expected,
                                   double tolerance_px,
                                   std::uint64_t seed) {
    std::mt19937_64 random(seed);
    Eigen::Isometry3d best = expected;
    double min_cost = msac_cost(rig, pairs, best, tolerance_px);
    int tries = stats::num_ransac_iterations(
        find_inliers(rig, pairs, best, tolerance_px).size(), pairs.size(), kRansac);
    for (int i = 0; i < tries; ++i) {
        const PointPair& pair = pairs[random() % pairs.size()];
        Eigen::Isometry3d guess = Eigen::Isometry3d::Identity();
        guess.linear() = R_current_previous;
        guess.translation() = pair.p_current - R_current_previous * pair.p_previous;
        const double cost = msac_cost(rig, pairs, guess, tolerance_px);
        if (cost >= min_cost) continue;
        min_cost = cost;
        best = guess;
        tries = stats::num_ransac_iterations(
            find_inliers(rig, pairs, best, tolerance_px).size(), pairs.size(), kRansac);
    }
    return best;
}

// Refines the motion over its inliers, then once more over those that agree with the result.
Registration settled(const types::RectifiedRig& rig,
                     const PointPairs& pairs,
                     const Eigen::Isometry3d& T_current_previous,
                     double tolerance_px) {
    Registration result;
    result.num_pairs = pairs.size();
    result.T_current_previous = T_current_previous;
    result.inliers = find_inliers(rig, pairs, T_current_previous, tolerance_px);
    for (int i = 0; i < 2 && result.inliers.size() >= kMinInliers; ++i) {
        result.T_current_previous =
            refine_pose(rig, result.inliers, {result.T_current_previous, std::nullopt, 0.0})
                .T_current_previous;
        result.inliers = find_inliers(rig, pairs, result.T_current_previous, tolerance_px);
    }
    result.found = result.inliers.size() >= kMinInliers;
    return result;
}

double horn_scale(const PointPairs& pairs) {
    std::vector<Eigen::Vector3d> previous;
    std::vector<Eigen::Vector3d> current;
    for (const PointPair& pair : pairs) {
        previous.push_back(pair.p_previous);
        current.push_back(pair.p_current);
    }
    const auto aligned = base::absolute_orientation(previous, current);
    return aligned ? aligned->scale : 1.0;
}

// Judges whether the inliers determine the motion, and sets the fields that say so.
void judge(const types::RectifiedRig& rig,
           const std::optional<types::KnownRotation>& rotation,
           Registration& result) {
    if (!result.found) return;
    result.scale = horn_scale(result.inliers);
    const MotionGuess motion{result.T_current_previous, rotation, 0.0};
    result.degenerate = max_sigma_rad(rig, result.inliers, motion) > kMaxSigma_rad;
    result.found = !result.degenerate;
}

}  // namespace

Registration register_with_rotation(const types::RectifiedRig& rig,
                                    const PointPairs& pairs,
                                    const std::optional<types::KnownRotation>& rotation,
                                    const Eigen::Isometry3d& expected,
                                    double tolerance_px,
                                    std::uint64_t seed) {
    Registration result;
    result.num_pairs = pairs.size();
    if (pairs.size() < kMinInliers) return result;
    if (rotation) {
        const Eigen::Isometry3d best = best_translation(
            rig, pairs, rotation->q.toRotationMatrix(), expected, tolerance_px, seed);
        result = settled(rig, pairs, best, tolerance_px);
    }
    const auto is_confirmed = [&] {
        return static_cast<double>(result.inliers.size()) >=
               kMinTrustedShare * static_cast<double>(pairs.size());
    };
    const auto try_also = [&](const Eigen::Isometry3d& T_current_previous) {
        Registration other = settled(rig, pairs, T_current_previous, tolerance_px);
        if (other.inliers.size() > result.inliers.size()) result = std::move(other);
    };
    if (!is_confirmed()) {
        const Registration horn = register_points(rig, pairs, tolerance_px, seed);
        if (horn.found) try_also(horn.T_current_previous);
    }
    if (!is_confirmed() && !rotation) try_also(expected);  // Horn errs on far points
    judge(rig, rotation, result);
    return result;
}

Registration register_near(const types::RectifiedRig& rig,
                           const PointPairs& pairs,
                           const std::optional<types::KnownRotation>& rotation,
                           const Eigen::Isometry3d& expected,
                           double tolerance_px) {
    Registration result = settled(rig, pairs, expected, tolerance_px);
    judge(rig, rotation, result);
    return result;
}

}  // namespace divemesh::odometry
