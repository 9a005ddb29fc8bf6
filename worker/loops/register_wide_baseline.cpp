#include "worker/loops/register_wide_baseline.hpp"

#include <algorithm>
#include <cmath>
#include <random>

#include "worker/base/horn.hpp"
#include "worker/odometry/pair_inliers.hpp"
#include "worker/odometry/refine_pose.hpp"
#include "worker/odometry/support.hpp"
#include "worker/stats/num_ransac_iterations.hpp"

namespace divemesh::loops {
namespace {

constexpr stats::RansacLimits kRansac{.max_iterations = 600};
constexpr double kTolerance_px = 3.0;
constexpr std::size_t kMinInliers = 10;
constexpr std::size_t kMinInliersWithPrior = 8;
constexpr double kMaxSigma_rad = 0.02;  // ten pixels: worse than a prediction
constexpr double kRotationSlack_rad = 0.02;
constexpr double kNumSigmas = 3.5;
constexpr std::size_t kMinCells = 5;  // cells of the image with an inlier

std::optional<Eigen::Isometry3d> motion_of_three(const types::RectifiedRig& rig,
                                                 const odometry::PointPairs& pairs,
                                                 std::mt19937_64& random) {
    odometry::PointPairs three;
    std::vector<Eigen::Vector3d> from;
    std::vector<Eigen::Vector3d> to;
    for (int k = 0; k < 3; ++k) {
        three.push_back(pairs[random() % pairs.size()]);
        from.push_back(three.back().p_previous);
        to.push_back(three.back().p_current);
    }
    const auto horn = base::absolute_orientation(from, to);
    if (!horn) return std::nullopt;
    return odometry::refine_pose(rig, three, {horn->T_b_a, std::nullopt, 0.0}).T_current_previous;
}

Eigen::Isometry3d best_motion(const types::RectifiedRig& rig,
                              const odometry::PointPairs& pairs,
                              std::uint64_t seed) {
    std::mt19937_64 random(seed);
    Eigen::Isometry3d best = Eigen::Isometry3d::Identity();
    double min_cost = odometry::msac_cost(rig, pairs, best, kTolerance_px);
    int tries = kRansac.max_iterations;
    for (int i = 0; i < tries; ++i) {
        const auto motion = motion_of_three(rig, pairs, random);
        if (!motion) continue;
        const double cost = odometry::msac_cost(rig, pairs, *motion, kTolerance_px);
        if (cost >= min_cost) continue;
        min_cost = cost;
        best = *motion;
        const auto inliers = odometry::find_inliers(rig, pairs, best, kTolerance_px);
        tries = std::min(
            tries, i + 1 + stats::num_ransac_iterations(inliers.size(), pairs.size(), kRansac));
    }
    return best;
}

bool fits(const std::optional<types::KnownRotation>& rotation, const Eigen::Isometry3d& T_b_a) {
    return rotation && rotation->q.angularDistance(Eigen::Quaterniond(T_b_a.linear())) <
                           kRotationSlack_rad + kNumSigmas * rotation->sigma_rad;
}

// Refines a motion over its inliers. Returns nullopt if they are fewer than `min_inliers`, all in a
// corner, or do not determine the motion.
std::optional<Eigen::Isometry3d> confirmed(const types::RectifiedRig& rig,
                                           const odometry::PointPairs& pairs,
                                           Eigen::Isometry3d T_b_a,
                                           const MotionPrior& prior) {
    odometry::PointPairs inliers = odometry::find_inliers(rig, pairs, T_b_a, kTolerance_px);
    for (int i = 0; i < 2 && inliers.size() >= kMinInliersWithPrior; ++i) {
        T_b_a = odometry::refine_pose(rig, inliers, {T_b_a, std::nullopt, 0.0}).T_current_previous;
        inliers = odometry::find_inliers(rig, pairs, T_b_a, kTolerance_px);
    }
    const std::size_t wanted = fits(prior.rotation, T_b_a) ? kMinInliersWithPrior : kMinInliers;
    if (inliers.size() < wanted || odometry::num_cells(rig, inliers) < kMinCells ||
        odometry::max_sigma_rad(rig, inliers, {T_b_a, std::nullopt, 0.0}) > kMaxSigma_rad)
        return std::nullopt;
    return T_b_a;
}

std::optional<Eigen::Isometry3d> register_pairs(const types::RectifiedRig& rig,
                                                const odometry::PointPairs& pairs,
                                                const MotionPrior& prior,
                                                std::uint64_t seed) {
    if (pairs.size() < kMinInliersWithPrior) return std::nullopt;
    if (prior.T_b_a)
        if (auto predicted = confirmed(rig, pairs, *prior.T_b_a, prior)) return predicted;
    return confirmed(rig, pairs, best_motion(rig, pairs, seed), prior);
}

}  // namespace

std::optional<Eigen::Isometry3d> register_wide_baseline(const types::RectifiedRig& rig,
                                                        const SiftKeypoints& a,
                                                        const SiftKeypoints& b,
                                                        const MotionPrior& prior,
                                                        std::uint64_t seed) {
    if (auto found = register_pairs(rig, match_sift(rig, a, b), prior, seed)) return found;
    if (!prior.T_b_a) return std::nullopt;
    return register_pairs(rig, match_sift(rig, a, b, prior.T_b_a), prior, seed);
}

}  // namespace divemesh::loops
