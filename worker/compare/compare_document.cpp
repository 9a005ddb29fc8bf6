#include "worker/compare/compare_document.hpp"

#include <cmath>

#include "schemas/json.hpp"
#include "worker/base/angle.hpp"
#include "worker/compare/change_metric.hpp"
#include "worker/compare/compare_findings.hpp"
#include "worker/evaluation/tracking_segments.hpp"
#include "worker/io/solver_json.hpp"
#include "worker/stats/distributions.hpp"

namespace divemesh::compare {
namespace {

using nlohmann::json;

json dive_of(const io::ReconstructionFolder& folder) {
    const json& metrics = folder.metrics();
    const auto text = [&](const char* path) {
        return metrics.value(json::json_pointer(path), std::string());
    };
    const auto segments = folder.segments();
    json dive = {{"name", text("/dive/name")},
                 {"content_sha256", text("/dive/content_sha256")},
                 {"version", text("/version")},
                 {"preset", text("/preset")},
                 {"restrictions", folder.restrictions()},
                 {"scale_sigma", folder.scale_sigma()},
                 {"num_segments", segments.size()},
                 {"segment", evaluation::number_of_largest(segments)}};
    if (const auto verdict = folder.verdict()) dive["verdict"] = to_string(*verdict);
    return dive;
}

json to_json(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }
json to_json(const Eigen::Vector2d& v) { return {v.x(), v.y()}; }
json to_json(const stats::Estimate& estimate) { return estimate_json(estimate); }

json to_json(const CoRegistration& fit) {
    const Eigen::Quaterniond q(fit.T_a_b.linear());
    const auto bound = [&](int i) {
        return stats::kNormal975 * std::sqrt(std::max(0.0, fit.covariance(i, i)));
    };
    json result = {{"method", fit.method},
                   {"T_a_b",
                    {{"position_m", to_json(Eigen::Vector3d(fit.T_a_b.translation()))},
                     {"orientation_wxyz", {q.w(), q.x(), q.y(), q.z()}}}},
                   {"overlap", fit.overlap},
                   {"agreement", fit.agreement},
                   {"tolerance_m", fit.tolerance_m},
                   {"stable_share", fit.stable_share},
                   {"residual_rms_m", fit.residual_rms_m},
                   {"num_patches", fit.num_patches},
                   {"solver", io::to_json(fit.outcome)},
                   {"uncertainty95",
                    {{"about_m", to_json(fit.pivot)},
                     {"x_m", bound(3)},
                     {"y_m", bound(4)},
                     {"z_m", bound(5)},
                     {"tilt_deg", base::kDegPerRad * std::hypot(bound(0), bound(1))},
                     {"heading_deg", base::kDegPerRad * bound(2)}}}};
    if (fit.scale)
        result["scale_difference"] = {{"value", fit.scale->value},
                                      {"sigma", fit.scale->sigma},
                                      {"lever_m", fit.scale->lever_m}};
    return result;
}

json to_json(const ChangeTotal& total) {
    return {{"num_patches", total.num_patches},
            {"area_m2", to_json(total.area_m2)},
            {"volume_m3", to_json(total.volume_m3)},
            {"undetected_m3", total.undetected_m3}};
}

json to_json(const ChangePatch& patch) {
    return {{"number", patch.number},
            {"kind", patch.grown ? "grown" : "lost"},
            {"area_m2", to_json(patch.area_m2)},
            {"volume_m3", to_json(patch.volume_m3)},
            {"center_m", to_json(patch.center_m)},
            {"box", {{"min", to_json(patch.box_m.min())}, {"max", to_json(patch.box_m.max())}}},
            {"mean_change_m", patch.mean_change_m},
            {"largest_change_m", patch.largest_change_m},
            {"hidden_m2", patch.hidden_m2}};
}

json ground_of(const ComparisonResult& result) {
    const ChangeMap& map = result.map;
    const double stable = map.area_m2(CellState::Stable);
    const double grown = map.area_m2(CellState::Grown);
    const double lost = map.area_m2(CellState::Lost);
    return {{"both_m2", stable + grown + lost},
            {"only_a_m2", map.area_m2(CellState::OnlyA)},
            {"only_b_m2", map.area_m2(CellState::OnlyB)},
            {"hidden_m2", map.area_m2(CellState::Hidden)},
            {"visibility_checked", result.visibility_checked}};
}

json noise_of(const Changes& changes) {
    json steps = json::array();
    for (const ChangeNoise::Step& step : changes.noise.steps())
        steps.push_back(
            {{"side_m", step.side_m}, {"sigma", step.sigma}, {"num_blocks", step.num_blocks}});
    return steps;
}

}  // namespace

json compare_document(const ComparisonResult& result) {
    json patches = json::array();
    for (const ChangePatch& patch : result.changes.patches) patches.push_back(to_json(patch));
    const CompareOptions& options = result.options;
    return {{"format", 1},
            {"a", dive_of(result.a)},
            {"b", dive_of(result.b)},
            {"options",
             {{"cell_m", options.cell_m},
              {"normal_scale_m", options.normal_scale_m},
              {"cylinder_m", options.cylinder_m},
              {"reach_m", options.reach_m},
              {"least_area_m2", options.least_area_m2}}},
            {"registration", to_json(result.registration)},
            {"ground", ground_of(result)},
            {"distances",
             {{"num", result.distances.num},
              {"num_known", result.distances.num_known},
              {"median_m", result.distances.median_m},
              {"median_abs_m", result.distances.median_abs_m},
              {"median_lod95_m", result.distances.median_lod95_m},
              {"level_factor", result.distances.level_factor}}},
            {"noise", noise_of(result.changes)},
            {"grown", to_json(result.changes.grown)},
            {"lost", to_json(result.changes.lost)},
            {"rest",
             {{"area_m2", result.changes.rest_m2},
              {"volume_m3", to_json(result.changes.rest_m3)},
              {"beyond_share", result.changes.beyond_share}}},
            {"patches", patches},
            {"findings", compare_findings(result)}};
}

}  // namespace divemesh::compare
