#include "worker/odometry/register_points.hpp"

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "worker/base/horn.hpp"
#include "worker/odometry/pair_inliers.hpp"
#include "worker/stats/num_ransac_iterations.hpp"

namespace divemesh::odometry {
namespace {

constexpr stats::RansacLimits kRansac{.confidence = 0.9999, .max_iterations = 400};

std::optional<base::AbsoluteOrientation> align(const PointPairs& pairs) {
    std::vector<Eigen::Vector3d> previous;
    std::vector<Eigen::Vector3d> current;
    for (const PointPair& pair : pairs) {
        previous.push_back(pair.p_previous);
        current.push_back(pair.p_current);
    }
    return base::absolute_orientation(previous, current);
}

PointPairs sample_three(const PointPairs& pairs, std::mt19937_64& random) {
    const auto draw = [&] { return static_cast<std::size_t>(random() % pairs.size()); };
    const std::size_t first = draw();
    std::size_t second = draw();
    while (second == first) second = draw();
    std::size_t third = draw();
    while (third == first || third == second) third = draw();
    return {pairs[first], pairs[second], pairs[third]};
}

}  // namespace

Registration register_points(const types::RectifiedRig& rig,
                             const PointPairs& pairs,
                             double tolerance_px,
                             std::uint64_t seed) {
    Registration result;
    result.num_pairs = pairs.size();
    if (pairs.size() < kMinInliers) return result;
    std::mt19937_64 random(seed);
    double min_cost = 1e300;
    int tries = kRansac.max_iterations;
    for (int i = 0; i < tries; ++i) {
        const auto guess = align(sample_three(pairs, random));
        if (!guess) continue;
        const double guess_cost = msac_cost(rig, pairs, guess->T_b_a, tolerance_px);
        if (guess_cost >= min_cost) continue;
        min_cost = guess_cost;
        result.T_current_previous = guess->T_b_a;
        result.inliers = find_inliers(rig, pairs, guess->T_b_a, tolerance_px);
        tries = std::min(
            tries,
            i + 1 + stats::num_ransac_iterations(result.inliers.size(), pairs.size(), kRansac));
    }
    // Horn over all inliers, then once more over those that agree with the result.
    for (int i = 0; i < 2; ++i) {
        const auto all = align(result.inliers);
        if (!all) break;
        auto inliers = find_inliers(rig, pairs, all->T_b_a, tolerance_px);
        if (inliers.size() < result.inliers.size() * 9 / 10) break;  // far points distort it
        result.T_current_previous = all->T_b_a;
        result.scale = all->scale;
        result.inliers = std::move(inliers);
    }
    result.found = result.inliers.size() >= kMinInliers;
    return result;
}

}  // namespace divemesh::odometry
