#include "worker/optimisation/noise_scale.hpp"

#include <algorithm>
#include <cmath>

namespace divemesh::optimisation {
namespace {

constexpr double kMinScale = 1.0;
constexpr double kMaxCorrelation = 0.9;

}  // namespace

void NoiseScale::add(const Eigen::Vector3d& r, const Eigen::Vector3d* before, int rows) {
    const double norm = r.norm();
    const double weight = norm > huber_ ? huber_ / norm : 1.0;
    squares_ += weight * weight * norm * norm;
    divergence_ += norm > huber_ ? (rows - 1) * weight : rows;
    num_rows_ += rows;
    if (!before || norm > kOutlierSigmas || before->norm() > kOutlierSigmas) return;
    products_ += r.dot(*before);
    pair_squares_ += 0.5 * (norm * norm + before->squaredNorm());
    ++num_pairs_;
}

double NoiseScale::scale(int num_parameters) const {
    const double free = num_rows_ - num_parameters;
    if (free <= 0.0 || divergence_ <= 0.0) return 1.0;
    const double mean_slope = divergence_ / num_rows_;
    return std::max(kMinScale, std::sqrt(squares_ / free * repetition()) / mean_slope);
}

// Returns how many times neighbouring observations of a landmark repeat the same error. Fitting to
// n independent observations leaves a correlation of -1/n.
double NoiseScale::repetition() const {
    if (num_pairs_ == 0.0 || pair_squares_ <= 0.0) return 1.0;
    const double length = num_pairs_ / num_landmarks_ + 1.0;
    const double correlation =
        std::clamp(products_ / pair_squares_ + 1.0 / length, 0.0, kMaxCorrelation);
    return (1.0 + correlation) / (1.0 - correlation);
}

}  // namespace divemesh::optimisation
