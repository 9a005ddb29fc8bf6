#include "worker/dive/smooth_rates.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <utility>

#include "worker/stats/median.hpp"
#include "worker/stats/robust.hpp"

namespace divemesh::dive {
namespace {

constexpr int kNumTerms = 9;
constexpr std::size_t kMinSamples = 45;  // five for each term
constexpr int kNumRounds = 5;
constexpr double kMinScale_px_s = 0.1;
constexpr double kPriorInformation = 1e-6;

using Terms = Eigen::Matrix<double, kNumTerms, 1>;

// Returns what a rotation (by ray) and a translation (by ray and inverse depth) act by.
Terms terms_of(const EpipolarSample& s) {
    const double x = s.ray.x();
    const double y = s.ray.y();
    const double d = s.inverse_depth_1_m;
    Terms terms;
    terms << 1.0, x, y, x * x, x * y, y * y, d, d * x, d * y;
    return terms;
}

double robust_scale(const std::vector<EpipolarSample>& samples, const Terms& motion) {
    std::vector<double> sizes;
    sizes.reserve(samples.size());
    for (const EpipolarSample& s : samples)
        sizes.push_back(std::abs(s.rate_px_s - motion.dot(terms_of(s))));
    return std::max(kMinScale_px_s, stats::kSigmasPerMad * stats::upper_median(std::move(sizes)));
}

}  // namespace

void smooth_rates(std::vector<EpipolarSample>& samples) {
    if (samples.size() < kMinSamples) return;
    std::vector<double> rates;
    rates.reserve(samples.size());
    for (const EpipolarSample& s : samples) rates.push_back(s.rate_px_s);
    Terms motion = Terms::Zero();
    motion[0] = stats::upper_median(std::move(rates));
    for (int i = 0; i < kNumRounds; ++i) {
        const double limit = stats::kTukey * robust_scale(samples, motion);
        Eigen::Matrix<double, kNumTerms, kNumTerms> H =
            kPriorInformation * Eigen::Matrix<double, kNumTerms, kNumTerms>::Identity();
        Terms b = Terms::Zero();
        for (const EpipolarSample& s : samples) {
            const Terms terms = terms_of(s);
            const double weight = stats::tukey_weight(s.rate_px_s - motion.dot(terms), limit);
            H += weight * terms * terms.transpose();
            b += weight * s.rate_px_s * terms;
        }
        motion = H.ldlt().solve(b);
    }
    for (EpipolarSample& s : samples) s.rate_px_s = motion.dot(terms_of(s));
}

}  // namespace divemesh::dive
