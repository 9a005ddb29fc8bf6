#include "worker/reef/measure_reconstruction.hpp"

#include <array>

#include "schemas/error.hpp"
#include "schemas/json.hpp"
#include "schemas/verdict.hpp"
#include "worker/base/atomic_file.hpp"
#include "worker/evaluation/mesh_without_contradiction.hpp"
#include "worker/evaluation/trajectory_error.hpp"
#include "worker/io/csv_cell.hpp"
#include "worker/io/trajectory_file.hpp"

namespace divemesh::reef {
namespace {

using nlohmann::json;

double number_at(const json& metrics, const char* pointer) {
    const json::json_pointer place(pointer);
    return metrics.contains(place) && metrics[place].is_number() ? metrics[place].get<double>()
                                                                 : 0.0;
}

// Returns the verdict, what is restricted, and the findings that restrict more than the path. A
// file of an older version states no verdict.
json judgement_on(const io::ReconstructionFolder& reconstruction) {
    json judgement = {{"findings", json::array()}};
    for (const Finding& finding : reconstruction.findings()) {
        const std::string_view restricts = restriction_of(finding);
        if (!restricts.empty() && restricts != "path") judgement["findings"].push_back(finding);
    }
    const auto verdict = reconstruction.verdict();
    if (!verdict) return judgement;
    judgement["verdict"] = to_string(*verdict);
    judgement["restrictions"] = reconstruction.restrictions();
    return judgement;
}

}  // namespace

MeasureOptions measure_options(const io::ReconstructionFolder& reconstruction) {
    MeasureOptions options;
    for (const types::StampedPose& pose : reconstruction.trajectory())
        options.camera_positions_world.push_back(pose.T_world_imu.translation());
    options.focal_px = reconstruction.matched_focal_px();
    options.min_detail_m = 2.0 * number_at(reconstruction.metrics(), "/mesh/voxel_m");
    options.is_simplified = reconstruction.is_simplified();
    options.vertical_is_known = reconstruction.vertical_is_known();
    options.sigma_shared_m =
        number_at(reconstruction.metrics(), "/expected_accuracy/surface/sigma_shared_m");
    options.scale_sigma = reconstruction.scale_sigma();
    return options;
}

AreaSet areas_in_world(const AreaSet& set,
                       const types::Trajectory& estimate,
                       const std::optional<types::Trajectory>& ground_truth) {
    if (set.frame == AreaFrame::World) return set;
    if (!ground_truth)
        throw Error(ErrorCode::InvalidArgument,
                    "the areas are in the ground truth's frame: give its trajectory");
    const evaluation::TrajectoryError error = evaluation::trajectory_error(estimate, *ground_truth);
    return moved(set, error.T_reference_surface.inverse());
}

json measure_reconstruction(const MeasureRequest& request) {
    const io::ReconstructionFolder reconstruction(request.reconstruction);
    AreaSet areas;
    if (request.areas)
        areas = parse_areas(import_areas(*request.areas, reconstruction, request.area_import));
    std::optional<types::Trajectory> truth;
    if (request.ground_truth) truth = io::read_trajectory(*request.ground_truth).poses;
    areas = areas_in_world(areas, reconstruction.trajectory(), truth);
    MeasureOptions options = measure_options(reconstruction);
    options.num_threads = request.num_threads;
    json measured =
        measure_areas(evaluation::mesh_without_contradiction(reconstruction), areas, options);
    measured["reconstruction"] = judgement_on(reconstruction);
    return measured;
}

std::string metrics_csv(const json& metrics) {
    constexpr std::array<const char*, 10> kColumns = {"figure",
                                                      "area",
                                                      "label",
                                                      "unit",
                                                      "resolution_m",
                                                      "value",
                                                      "low",
                                                      "high",
                                                      "method",
                                                      "refused"};
    std::string csv;
    for (const char* column : kColumns) csv.append(csv.empty() ? "" : ",").append(column);
    csv += "\n";
    for (const json& metric : metrics) {
        std::string row;
        for (const char* column : kColumns) {
            if (column != kColumns.front()) row += ",";
            row += io::csv_cell_of(metric.value(column, json()));
        }
        csv += row + "\n";
    }
    return csv;
}

void write_metrics_csv(const json& metrics, const std::filesystem::path& path) {
    base::write_file(path, metrics_csv(metrics));
}

}  // namespace divemesh::reef
