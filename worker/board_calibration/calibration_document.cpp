#include "worker/board_calibration/calibration_document.hpp"

#include <cmath>

#include "schemas/json.hpp"
#include "worker/camera/lens_model.hpp"

namespace divemesh::board_calibration {
namespace {

using nlohmann::json;

std::string_view name_of(types::Distortion distortion) {
    return camera::lens_model(distortion).name;
}

json parameters(const RigEstimate& estimate) {
    json list = json::array();
    const RigVector values = estimate.rig.vector();
    const std::vector<std::string> names = estimate.rig.names();
    for (int i = 0; i < values.size(); ++i)
        list.push_back({{"name", names[static_cast<std::size_t>(i)]},
                        {"value", values[i]},
                        {"sigma", std::sqrt(estimate.covariance(i, i))}});
    return list;
}

json covariance_rows(const RigCovariance& covariance) {
    json rows = json::array();
    for (int i = 0; i < covariance.rows(); ++i) {
        json row = json::array();
        for (int j = 0; j < covariance.cols(); ++j) row.push_back(covariance(i, j));
        rows.push_back(std::move(row));
    }
    return rows;
}

// The root mean square of the errors of one axis.
struct Rms {
    double squares_px2 = 0.0;
    int num = 0;

    void add(const Eigen::Vector2d& error_px) {
        squares_px2 += error_px.squaredNorm();
        ++num;
    }
    json value() const { return num > 0 ? json(std::sqrt(squares_px2 / (2.0 * num))) : json(); }
};

json pairs(const RigEstimate& estimate) {
    std::vector<std::array<Rms, 2>> rms(estimate.views.size());
    for (const CornerError& error : estimate.errors)
        rms[error.view][error.is_right ? 1 : 0].add(error.error_px);
    json list = json::array();
    for (std::size_t i = 0; i < rms.size(); ++i)
        list.push_back({{"timestamp_ns", estimate.views[i].view.timestamp_ns},
                        {"num_corners_cam0", rms[i][0].num},
                        {"num_corners_cam1", rms[i][1].num},
                        {"rms_cam0_px", rms[i][0].value()},
                        {"rms_cam1_px", rms[i][1].value()}});
    return list;
}

json cameras(const RigEstimate& estimate, const RigVerdict& verdict) {
    std::array<Rms, 2> rms;
    for (const CornerError& error : estimate.errors)
        rms[error.is_right ? 1 : 0].add(error.error_px);
    const auto camera = [](const LensKind& kind, const Rms& errors, const ImageCoverage& coverage) {
        return json{{"width_px", kind.width_px},
                    {"height_px", kind.height_px},
                    {"model", name_of(kind.distortion)},
                    {"rms_px", errors.value()},
                    {"num_corners", errors.num},
                    {"coverage_share", coverage.share()},
                    {"coverage_cells", coverage.num_corners},
                    {"empty_sixths", coverage.empty_sixths()}};
    };
    return {{"cam0", camera(estimate.rig.kind0, rms[0], verdict.coverage.left)},
            {"cam1", camera(estimate.rig.kind1, rms[1], verdict.coverage.right)}};
}

json length_rows(const std::vector<LengthError>& errors) {
    json list = json::array();
    for (const LengthError& error : errors)
        list.push_back({{"distance_m", error.distance_m},
                        {"center_sigma", error.center ? json(*error.center) : json()},
                        {"border_sigma", error.border ? json(*error.border) : json()}});
    return list;
}

json shape_json(const std::optional<BoardShape>& shape) {
    if (!shape) return nullptr;
    return {{"num_corners", shape->num_corners},
            {"num_pairs", shape->num_views},
            {"flatness_rms_m", shape->flatness_rms_m},
            {"flatness_max_m", shape->flatness_max_m},
            {"step_error", shape->step_error},
            {"step_spread", shape->step_spread}};
}

json models(const RigEstimate& estimate) {
    json list = json::array();
    for (const ModelFit& fit : estimate.models)
        list.push_back({{"model", name_of(fit.distortion)},
                        {"rms_cam0_px", fit.left_rms_px},
                        {"rms_cam1_px", fit.right_rms_px}});
    return list;
}

}  // namespace

json calibration_document(const RigEstimate& estimate, const RigVerdict& verdict) {
    json document = {{"format", 1},
                     {"usable", verdict.usable},
                     {"verdict", verdict.text},
                     {"models", models(estimate)},
                     {"findings", verdict.findings}};
    json left_out = json::array();
    for (const ViewLeftOut& view : estimate.left_out)
        left_out.push_back({{"timestamp_ns", view.timestamp_ns}, {"rms_px", view.rms_px}});
    document["pairs_left_out"] = std::move(left_out);
    if (!estimate.failure.empty()) {
        document["failure"] = estimate.failure;
        return document;
    }
    document["parameters"] = parameters(estimate);
    document["covariance"] = covariance_rows(estimate.covariance);
    document["baseline_m"] = isometry_of(estimate.rig.T_cam1_cam0).translation().norm();
    document["corner_sigma_px"] = estimate.sigma_px;
    document["num_corners_left_out"] = estimate.num_corners_left_out;
    document["cameras"] = cameras(estimate, verdict);
    document["pairs"] = pairs(estimate);
    document["length_errors"] = length_rows(verdict.length_errors);
    document["distance_m"] = {verdict.coverage.distance_m.min, verdict.coverage.distance_m.max};
    document["tilt_deg"] = {verdict.coverage.tilt_deg.min, verdict.coverage.tilt_deg.max};
    document["board"] = shape_json(verdict.shape);
    return document;
}

}  // namespace divemesh::board_calibration
