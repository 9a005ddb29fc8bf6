#include "worker/optimisation/align_heading.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "worker/stats/median.hpp"

namespace divemesh::optimisation {
namespace {

constexpr std::size_t kMaxPoints = 150;
constexpr double kOutlier_sigmas = 3.0;

Eigen::Isometry3d by_heading(double yaw, const Eigen::Vector3d& p_site, const Eigen::Vector3d& p) {
    Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
    T.linear() = Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()).toRotationMatrix();
    T.translation() = p_site - T.linear() * p;
    return T;
}

double residual_sigmas(const OutsidePoint& point, const Eigen::Isometry3d& T_site_world) {
    return (point.p_site - T_site_world * point.p_world).head<2>().norm() / point.sigma_h_m;
}

double cost_of(const std::vector<OutsidePoint>& points, const Eigen::Isometry3d& T_site_world) {
    double cost = 0.0;
    for (const OutsidePoint& point : points)
        cost += std::pow(std::min(residual_sigmas(point, T_site_world), kOutlier_sigmas), 2);
    return cost;
}

double azimuth(const Eigen::Vector3d& v) { return std::atan2(v.y(), v.x()); }

}  // namespace

Eigen::Isometry3d align_heading(const std::vector<OutsidePoint>& points) {
    std::vector<OutsidePoint> some;
    const std::size_t stride = 1 + (points.size() - 1) / kMaxPoints;
    for (std::size_t i = 0; i < points.size(); i += stride) some.push_back(points[i]);
    Eigen::Isometry3d best = by_heading(0.0, points.front().p_site, points.front().p_world);
    double best_cost = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < some.size(); ++i)
        for (std::size_t j = i + 1; j < some.size(); ++j) {
            const double yaw = azimuth(some[j].p_site - some[i].p_site) -
                               azimuth(some[j].p_world - some[i].p_world);
            const Eigen::Isometry3d T = by_heading(yaw,
                                                   0.5 * (some[i].p_site + some[j].p_site),
                                                   0.5 * (some[i].p_world + some[j].p_world));
            const double cost = cost_of(some, T);
            if (cost >= best_cost) continue;
            best_cost = cost;
            best = T;
        }
    return best;
}

double median_residual_sigmas(const std::vector<OutsidePoint>& points,
                              const Eigen::Isometry3d& T_site_world) {
    std::vector<double> residuals;
    residuals.reserve(points.size());
    for (const OutsidePoint& point : points)
        residuals.push_back(residual_sigmas(point, T_site_world));
    return stats::upper_median(std::move(residuals));
}

}  // namespace divemesh::optimisation
