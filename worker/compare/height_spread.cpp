#include "worker/compare/height_spread.hpp"

#include <Eigen/Cholesky>
#include <cmath>

#include "worker/stats/quantile.hpp"

namespace divemesh::compare {

double percentile_80(std::vector<double> values) {
    for (double& value : values) value = std::abs(value);
    return stats::upper_quantile(std::move(values), 0.8);
}

double height_spread_m(const std::vector<Eigen::Vector3d>& places) {
    if (places.size() < 4) return 0.0;
    Eigen::Vector3d middle = Eigen::Vector3d::Zero();
    for (const Eigen::Vector3d& p : places) middle += p;
    middle /= static_cast<double>(places.size());
    Eigen::Matrix2d spread = Eigen::Matrix2d::Zero();
    Eigen::Vector2d rise = Eigen::Vector2d::Zero();
    for (const Eigen::Vector3d& p : places) {
        const Eigen::Vector2d at = (p - middle).head<2>();
        spread += at * at.transpose();
        rise += (p.z() - middle.z()) * at;
    }
    if (spread.determinant() <= 1e-9 * spread.trace() * spread.trace()) return 0.0;
    const Eigen::Vector2d slope = spread.ldlt().solve(rise);
    std::vector<double> heights;
    heights.reserve(places.size());
    for (const Eigen::Vector3d& p : places)
        heights.push_back(p.z() - middle.z() - slope.dot((p - middle).head<2>()));
    return percentile_80(std::move(heights));
}

}  // namespace divemesh::compare
