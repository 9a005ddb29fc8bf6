#include "worker/markers/marker_metrics.hpp"

#include <cmath>

#include "worker/stats/distributions.hpp"

namespace divemesh::markers {
namespace {

using nlohmann::json;

json to_array(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

json to_json(const dive::MarkerPoint& point) {
    if (!point.corner) return point.id;
    return {{"id", point.id}, {"corner", dive::to_string(*point.corner)}};
}

json to_json(const Marker& marker, const MarkerMetrics& metrics) {
    const Eigen::Quaterniond q(marker.T_world_marker.linear());
    const Eigen::Matrix3d covariance = marker.covariance_m2();
    json corners = json::array();
    for (const Eigen::Vector3d& corner : marker.corners_world) corners.push_back(to_array(corner));
    json result = {
        {"id", marker.id},
        {"family", dive::to_string(metrics.family)},
        {"piece", marker.segment},
        {"num_views", marker.num_views},
        {"num_keyframes", marker.num_keyframes},
        {"num_rejected_views", marker.num_rejected_views},
        {"position_m", to_array(marker.T_world_marker.translation())},
        {"orientation_wxyz", {q.w(), q.x(), q.y(), q.z()}},
        {"sigma_m", std::sqrt(covariance.trace())},
        {"covariance_m2",
         {to_array(covariance.row(0)), to_array(covariance.row(1)), to_array(covariance.row(2))}},
        {"reprojection_rms_px", marker.reprojection_rms_px},
        {"corners_m", corners},
        {"edges_m", marker.edges_m()}};
    for (const BarMetrics& bar : metrics.bars)
        if (bar.is_printed_size && bar.from.id == marker.id) result["size_m"] = bar.known_m;
    return result;
}

json error_of(double error_m, double known_m) {
    return {{"error_mm", 1e3 * error_m}, {"error_percent", 100.0 * error_m / known_m}};
}

json to_json(const BarMetrics& bar) {
    json result = {{"name", bar.name},
                   {"kind", bar.is_printed_size ? "printed_size" : "scale_bar"},
                   {"from", to_json(bar.from)},
                   {"to", to_json(bar.to)},
                   {"known_m", bar.known_m},
                   {"known_sigma_m", bar.known_sigma_m},
                   {"measured_m", nullptr}};
    if (!bar.measured_m) return result;
    result.update(error_of(bar.error_m(), bar.known_m));
    result["measured_m"] = *bar.measured_m;
    result["sigma_m"] = bar.sigma_m;
    const double half = stats::kNormal975 * bar.sigma_m;
    result["interval95_m"] = {std::max(0.0, *bar.measured_m - half), *bar.measured_m + half};
    if (!bar.leave_one_out_error_m) return result;
    result["leave_one_out"] = error_of(*bar.leave_one_out_error_m, bar.known_m);
    result["leave_one_out"]["sigma_m"] = bar.leave_one_out_sigma_m;
    result["consistent"] = bar.consistent;
    return result;
}

json to_json(const MarkerScale& scale) {
    return {{"factor", scale.factor}, {"sigma", scale.sigma}, {"bars", scale.bars}};
}

}  // namespace

Eigen::Vector3d Marker::point(const std::optional<dive::TagCorner>& corner) const {
    if (corner) return corners_world[static_cast<std::size_t>(*corner)];
    return 0.25 * (corners_world[0] + corners_world[1] + corners_world[2] + corners_world[3]);
}

std::array<double, dive::kNumTagCorners> Marker::edges_m() const {
    std::array<double, dive::kNumTagCorners> edges{};
    for (std::size_t i = 0; i < dive::kNumTagCorners; ++i)
        edges[i] = (corners_world[(i + 1) % dive::kNumTagCorners] - corners_world[i]).norm();
    return edges;
}

Eigen::Matrix3d Marker::covariance_m2() const {
    Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
    for (Eigen::Index i = 0; i < 12; i += 3)
        for (Eigen::Index j = 0; j < 12; j += 3) sum += corner_covariance_m2.block<3, 3>(i, j);
    return sum / (dive::kNumTagCorners * dive::kNumTagCorners) + drift_covariance_m2;
}

double BarMetrics::leave_one_out_sigmas() const {
    return leave_one_out_error_m ? std::abs(*leave_one_out_error_m) / leave_one_out_sigma_m : 0.0;
}

json to_metrics(const MarkerMetrics& metrics) {
    json markers = json::array();
    for (const Marker& marker : metrics.markers) markers.push_back(to_json(marker, metrics));
    json bars = json::array();
    std::int64_t num_measured = 0;
    for (const BarMetrics& bar : metrics.bars) {
        bars.push_back(to_json(bar));
        if (bar.measured_m) ++num_measured;
    }
    json result = {{"family", dive::to_string(metrics.family)},
                   {"num_markers", metrics.markers.size()},
                   {"markers", markers},
                   {"bars", bars},
                   {"num_bars_measured", num_measured},
                   {"systematic_scale_sigma", metrics.systematic_scale_sigma}};
    if (metrics.scale) result["scale"] = to_json(*metrics.scale);
    if (metrics.correction) {
        json correction = {{"applied", metrics.correction->applied}};
        if (metrics.correction->applied) correction.update(to_json(metrics.correction->scale));
        result["scale_correction"] = correction;
    }
    return result;
}

}  // namespace divemesh::markers
