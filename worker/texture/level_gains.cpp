#include "worker/texture/level_gains.hpp"

#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "worker/stats/median.hpp"
#include "worker/stats/robust.hpp"

namespace divemesh::texture {
namespace {

constexpr float kDark = 4.0F;      // a gain does not explain such values
constexpr float kBright = 250.0F;  // nor those that may be saturated

// The logarithms of how much brighter the lower keyframe of a pair is, of each seam.
using RatiosOfPairs = std::map<std::pair<std::int32_t, std::int32_t>, std::vector<double>>;

RatiosOfPairs compare_pairs(const SeamColors& colors, int channel) {
    RatiosOfPairs pairs;
    for (const Seam& seam : colors.seams) {
        const std::size_t lower = seam.keyframes[0] < seam.keyframes[1] ? 0 : 1;
        double first_sum = 0.0;
        double second_sum = 0.0;
        for (std::uint32_t i = 0; i < seam.num_samples; ++i) {
            const float first = colors.color(seam, lower, i)[channel];
            const float second = colors.color(seam, 1 - lower, i)[channel];
            if (std::min(first, second) <= kDark || std::max(first, second) >= kBright) continue;
            first_sum += static_cast<double>(first);
            second_sum += static_cast<double>(second);
        }
        if (first_sum > 0.0)
            pairs[std::minmax(seam.keyframes[0], seam.keyframes[1])].push_back(
                std::log(first_sum / second_sum));
    }
    return pairs;
}

// The ratio of a pair, with its weight: the inverse of its variance, less if it is beyond belief.
struct PairRatio {
    double log_ratio = 0.0;
    double weight = 0.0;
};

PairRatio ratio_of(const std::vector<double>& log_ratios) {
    constexpr double kSigmaLow = 0.02;
    constexpr double kAlike = 30.0;          // seams that err together, because they are neighbours
    const double max_ratio = std::log(4.0);  // beyond it they show different things
    PairRatio pair;
    pair.log_ratio = stats::median(log_ratios);
    std::vector<double> deviations;
    for (const double ratio : log_ratios) deviations.push_back(std::abs(ratio - pair.log_ratio));
    const double sigma = stats::kSigmasPerMad * stats::median(std::move(deviations)) + kSigmaLow;
    pair.weight = stats::tukey_weight(pair.log_ratio, max_ratio) *
                  static_cast<double>(log_ratios.size()) / (kAlike * sigma * sigma);
    return pair;
}

// Minimises the sum over pairs of w (l_a + ratio - l_b)^2 plus that of l^2 over the prior variance
// of the logarithms l, which makes their sum 0.
Eigen::VectorXd log_gains(const RatiosOfPairs& pairs, std::size_t num_keyframes) {
    constexpr double kPriorSigma = 0.2;
    const auto num = static_cast<Eigen::Index>(num_keyframes);
    std::vector<Eigen::Triplet<double>> lower;
    Eigen::VectorXd right = Eigen::VectorXd::Zero(num);
    for (int i = 0; i < num; ++i) lower.emplace_back(i, i, 1.0 / (kPriorSigma * kPriorSigma));
    for (const auto& [keyframes, log_ratios] : pairs) {
        const auto& [a, b] = keyframes;
        const PairRatio pair = ratio_of(log_ratios);
        lower.emplace_back(a, a, pair.weight);
        lower.emplace_back(b, b, pair.weight);
        lower.emplace_back(b, a, -pair.weight);
        right[a] -= pair.weight * pair.log_ratio;
        right[b] += pair.weight * pair.log_ratio;
    }
    Eigen::SparseMatrix<double> matrix(num, num);
    matrix.setFromTriplets(lower.begin(), lower.end());
    return Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>>(matrix).solve(right);
}

}  // namespace

std::vector<Eigen::Vector3f> level_gains(const SeamColors& colors, std::size_t num_keyframes) {
    std::vector<Eigen::Vector3f> gains(num_keyframes, Eigen::Vector3f::Ones());
    if (colors.seams.empty()) return gains;
    for (int channel = 0; channel < 3; ++channel) {
        const Eigen::VectorXd logs = log_gains(compare_pairs(colors, channel), num_keyframes);
        for (std::size_t i = 0; i < num_keyframes; ++i)
            gains[i][channel] = static_cast<float>(std::exp(logs[static_cast<Eigen::Index>(i)]));
    }
    return gains;
}

}  // namespace divemesh::texture
