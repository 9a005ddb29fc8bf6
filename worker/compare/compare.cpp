#include "worker/compare/compare.hpp"

#include <algorithm>
#include <cmath>

#include "schemas/error.hpp"
#include "worker/base/atomic_file.hpp"
#include "worker/base/parallel.hpp"
#include "worker/compare/area_changes.hpp"
#include "worker/compare/change_images.hpp"
#include "worker/compare/change_scatter.hpp"
#include "worker/compare/changed_mesh.hpp"
#include "worker/compare/co_register.hpp"
#include "worker/compare/compare_document.hpp"
#include "worker/compare/compare_report.hpp"
#include "worker/compare/compared_segment.hpp"
#include "worker/io/mesh_check.hpp"
#include "worker/mesh/mean_edge.hpp"
#include "worker/stats/distributions.hpp"
#include "worker/stats/quantile.hpp"

namespace divemesh::compare {
namespace {

constexpr double kMinCell_m = 0.005;
constexpr std::int64_t kMaxCells = 40'000'000;

void check_range(const char* name, double value, double low, double high) {
    if (value == 0.0 || (value >= low && value <= high)) return;
    throw Error(ErrorCode::InvalidArgument,
                std::string(name) + " is " + std::to_string(value) + ": choose " +
                    std::to_string(low) + " to " + std::to_string(high) + ", or 0");
}

void check(const CompareRequest& request) {
    const CompareOptions& options = request.options;
    check_range("cell_m", options.cell_m, 0.001, 1.0);
    check_range("normal_scale_m", options.normal_scale_m, 0.002, 10.0);
    check_range("cylinder_m", options.cylinder_m, 0.002, 10.0);
    check_range("reach_m", options.reach_m, 0.01, 10.0);
    check_range("least_area_m2", options.least_area_m2, 1e-6, 100.0);
    if (request.out.empty())
        throw Error(ErrorCode::InvalidArgument, "there is no folder for the comparison: give one");
    if (request.later_areas && !request.areas)
        throw Error(ErrorCode::InvalidArgument,
                    "there are areas of the later dive only: give those of the earlier dive too");
}

types::Mesh surface_of(const io::ReconstructionFolder& folder) {
    if (!folder.has_surface())
        throw Error(ErrorCode::BadData,
                    folder.path().string() +
                        " has no mesh.ply, because it was reconstructed without a surface: "
                        "reconstruct it again with surface=true");
    types::Mesh mesh = compared_surface(folder);
    if (mesh.triangles.empty())
        throw Error(ErrorCode::BadData,
                    (folder.path() / "mesh.ply").string() +
                        " has no triangles, so there is no surface to compare: use another dive");
    mesh.normals = io::unit_normals(mesh);
    mesh.sigma_local_m = {};  // not needed
    mesh.num_observations = {};
    return mesh;
}

CompareOptions settled(CompareOptions options, const types::Mesh& a, const types::Mesh& b) {
    if (options.cell_m == 0.0)
        options.cell_m = std::max({kMinCell_m, mesh::mean_edge_m(a), mesh::mean_edge_m(b)});
    if (options.normal_scale_m == 0.0) options.normal_scale_m = 8.0 * options.cell_m;
    if (options.cylinder_m == 0.0) options.cylinder_m = 4.0 * options.cell_m;
    if (options.least_area_m2 == 0.0)
        options.least_area_m2 = 4.0 * 0.785 * options.cylinder_m * options.cylinder_m;
    return options;
}

void move(types::Mesh& mesh, const Eigen::Isometry3d& T) {
    const Eigen::Matrix3f R = T.linear().cast<float>();
    for (Eigen::Vector3f& p : mesh.vertices) p = (T * p.cast<double>()).cast<float>();
    for (Eigen::Vector3f& n : mesh.normals) n = (R * n).normalized();
}

std::optional<Views> views_in(const io::ReconstructionFolder& folder, const Eigen::Isometry3d& T) {
    auto views = read_views(folder);
    if (views)
        for (Eigen::Isometry3d& T_cam_world : views->T_cam_world)
            T_cam_world = T_cam_world * T.inverse();
    return views;
}

// Returns the factor by which levels of detection hold for 95 % of stable ground. Most of the
// ground is stable, so its differences follow from the median and the 80th percentile. A mesh's
// sigma is that of one dive; errors that both dives share cancel in a difference.
double level_factor(const std::vector<M3c2Distance>& distances) {
    std::vector<float> ratios;
    for (const M3c2Distance& distance : distances)
        if (distance.known())
            ratios.push_back(static_cast<float>(stats::kNormal975) * std::abs(distance.distance_m) /
                             distance.lod95_m);
    return robust_sigma(ratios);
}

// Never goes below the uncertainty of the co-registration.
void scale_levels(std::vector<M3c2Distance>& distances,
                  const SurfacePoints& core,
                  const M3c2Options& options,
                  double factor) {
    for (std::size_t i = 0; i < distances.size(); ++i)
        if (distances[i].known())
            distances[i].lod95_m =
                std::max(static_cast<float>(factor) * distances[i].lod95_m,
                         options.registration95_m(core.points[i], core.normals[i]));
}

struct Distances {
    std::vector<M3c2Distance> of_a;
    std::vector<M3c2Distance> of_b;
    double level_factor = 1.0;
};

Distances measure(const types::Mesh& a,
                  const types::Mesh& b,
                  const CoRegistration& registration,
                  const CompareOptions& options,
                  int num_threads,
                  const base::ProgressShare& progress) {
    const auto cube_m = static_cast<float>(options.cylinder_m);
    const PointGrid grid_a(a.vertices, cube_m);
    const PointGrid grid_b(b.vertices, cube_m);
    const std::vector<float> spacing_a = mesh::vertex_spacing_m(a);
    const std::vector<float> spacing_b = mesh::vertex_spacing_m(b);
    const SurfacePoints points_a{a.vertices, a.normals, a.sigma_m, grid_a, spacing_a};
    const SurfacePoints points_b{b.vertices, b.normals, b.sigma_m, grid_b, spacing_b};
    const M3c2Options m3c2{
        .normal_scale_m = static_cast<float>(options.normal_scale_m),
        .cylinder_m = cube_m,
        .reach_m = static_cast<float>(options.reach_m),
        .independent_m = cube_m,  // a cylinder is seen through one patch of the images
        .registration95_m = [&](const Eigen::Vector3f& p, const Eigen::Vector3f& n) {
            return static_cast<float>(stats::kNormal975 *
                                      registration.sigma_m(p.cast<double>(), n.cast<double>()));
        }};
    Distances distances;
    progress.at(0.1);
    distances.of_b = m3c2_distances(points_b, points_a, points_b, m3c2, num_threads);
    progress.at(0.5);
    distances.of_a = m3c2_distances(points_a, points_a, points_b, m3c2, num_threads);
    distances.level_factor = level_factor(distances.of_b);
    scale_levels(distances.of_a, points_a, m3c2, distances.level_factor);
    scale_levels(distances.of_b, points_b, m3c2, distances.level_factor);
    return distances;
}

DistanceSummary summarise(const Distances& distances) {
    DistanceSummary summary{.num = distances.of_b.size(), .level_factor = distances.level_factor};
    std::vector<float> values;
    std::vector<float> sizes;
    std::vector<float> levels;
    for (const M3c2Distance& distance : distances.of_b) {
        if (!distance.known()) continue;
        values.push_back(distance.distance_m);
        sizes.push_back(std::abs(distance.distance_m));
        levels.push_back(distance.lod95_m);
    }
    summary.num_known = values.size();
    summary.median_m = static_cast<double>(stats::lower_quantile(std::move(values), 0.5));
    summary.median_abs_m = static_cast<double>(stats::lower_quantile(std::move(sizes), 0.5));
    summary.median_lod95_m = static_cast<double>(stats::lower_quantile(std::move(levels), 0.5));
    return summary;
}

struct Pair {
    io::ReconstructionFolder folder_a;
    io::ReconstructionFolder folder_b;
    types::Mesh a;
    types::Mesh b;
};

Pair read(const CompareRequest& request) {
    Pair pair{io::ReconstructionFolder(request.a), io::ReconstructionFolder(request.b), {}, {}};
    pair.a = surface_of(pair.folder_a);
    pair.b = surface_of(pair.folder_b);
    return pair;
}

void write_results(const std::filesystem::path& folder,
                   const Pair& pair,
                   const ChangeMap& map,
                   const Changes& changes,
                   const std::vector<ComparedOutline>& outlines,
                   const nlohmann::json& document) {
    const double full_m = full_change_m(map);
    const cv::Mat difference = draw_changes(pair.b, map, changes, outlines, full_m);
    write_difference(folder, difference, map, !outlines.empty(), full_m);
    base::write_file(folder / "report.html",
                     compare_report({document,
                                     draw_surface(pair.a, map.grid),
                                     draw_surface(pair.b, map.grid),
                                     difference,
                                     full_m}));
    if (document.contains("areas"))
        base::write_file(folder / "area_changes.csv",
                         area_changes_csv(document["areas"]["figures"]));
    base::write_file(folder / "compare.json", document.dump(2) + "\n");
}

std::optional<ComparedAreas> areas_of(const CompareRequest& request) {
    if (!request.areas) return std::nullopt;
    return read_compared_areas(*request.areas, request.later_areas);
}

// Returns which of the dives do not know their vertical, in words; empty if both know it.
std::string without_vertical(const Pair& pair) {
    const bool a_knows = pair.folder_a.vertical_is_known();
    const bool b_knows = pair.folder_b.vertical_is_known();
    if (a_knows && b_knows) return "";
    if (!a_knows && !b_knows) return "both dives";
    return a_knows ? "the later dive" : "the earlier dive";
}

CoRegistration lay_over(const Pair& pair,
                        const CompareRequest& request,
                        double spacing_m,
                        const base::ProgressShare& progress) {
    return co_register(pair.a,
                       pair.b,
                       {.spacing_m = spacing_m,
                        .num_threads = request.num_threads,
                        .seed = request.seed,
                        .known = align_by_markers(marker_positions(pair.folder_a),
                                                  marker_positions(pair.folder_b)),
                        .without_vertical = without_vertical(pair)},
                       progress);
}

}  // namespace

nlohmann::json compare_reconstructions(const CompareRequest& request,
                                       const base::ProgressCallback& report) {
    check(request);
    const auto stage = [&](const char* name, double begin, double end) {
        base::ProgressShare share{name, begin, end, report};
        share.at(0.0);
        return share;
    };
    const int threads = request.num_threads;
    const auto registering = stage("register", 0.0, 0.4);
    std::optional<ComparedAreas> areas = areas_of(request);
    Pair pair = read(request);
    CompareOptions options = settled(request.options, pair.a, pair.b);
    const CoRegistration registration = lay_over(pair, request, options.cell_m, registering);
    move(pair.b, registration.T_a_b);
    if (areas && areas->later) areas->later = reef::moved(*areas->later, registration.T_a_b);
    const Distances distances =
        measure(pair.a, pair.b, registration, options, threads, stage("measure", 0.4, 0.7));
    const auto changing = stage("change", 0.7, 0.85);
    const auto views_a = views_in(pair.folder_a, Eigen::Isometry3d::Identity());
    const auto views_b = views_in(pair.folder_b, registration.T_a_b);
    const RasterGrid grid = grid_over(pair.a, pair.b, options.cell_m, kMaxCells);
    options.cell_m = grid.cell_m;
    ChangeMap map = map_changes({pair.a, distances.of_a, views_a},
                                {pair.b, distances.of_b, views_b},
                                registration,
                                {.grid = grid,
                                 .scale_m = options.cylinder_m,
                                 .reach_m = options.reach_m,
                                 .num_threads = threads});
    changing.at(0.8);
    const Changes changes =
        gather_changes(map,
                       {.least_area_m2 = options.least_area_m2,
                        .core_area_m2 = 0.785 * options.cylinder_m * options.cylinder_m,
                        .margin_m = options.cylinder_m});
    stage("write", 0.85, 1.0);
    nlohmann::json document = compare_document({pair.folder_a,
                                                pair.folder_b,
                                                options,
                                                registration,
                                                summarise(distances),
                                                map,
                                                changes,
                                                views_a && views_b});
    if (areas) document["areas"] = area_changes(*areas, map, changes, request.seed);
    std::filesystem::create_directories(request.out);
    write_changed_mesh(
        request.out / "changed_mesh.ply", pair.b, distances.of_b, full_change_m(map));
    write_results(request.out,
                  pair,
                  map,
                  changes,
                  areas ? outlines_of(*areas) : std::vector<ComparedOutline>(),
                  document);
    return document;
}

}  // namespace divemesh::compare
