#include "worker/base/part_of.hpp"
#include "worker/evaluation/surface_samples.hpp"
#include "worker/io/ply.hpp"
#include "worker/mesh/cut_by_sigma.hpp"
#include "worker/mesh/vertex_sigma.hpp"
#include "worker/optimisation/expected_path_error.hpp"
#include "worker/pipeline/simplification_error.hpp"
#include "worker/pipeline/stage_files.hpp"
#include "worker/pipeline/stage_functions.hpp"
#include "worker/pipeline/water_color.hpp"

namespace divemesh::pipeline {
namespace {

Surface simplified(types::Mesh mesh,
                   const ReconstructionOptions& options,
                   const base::ProgressCallback& progress) {
    if (options.simplify >= 1.0 || mesh.triangles.empty()) return {std::move(mesh), std::nullopt};
    types::Mesh fewer = mesh::simplify_mesh(mesh, {options.simplify, options.simplify_error_m});
    const auto error = simplification_error(mesh, fewer, options.num_threads, progress);
    return {std::move(fewer), error};
}

// Cuts the surface in place. Returns the area that was removed, m2.
double cut_by_sigma(double max_sigma_m, types::Mesh& surface) {
    if (max_sigma_m <= 0.0) return 0.0;
    const double whole_m2 = evaluation::surface_area_m2(surface);
    surface = mesh::cut_by_sigma(std::move(surface), max_sigma_m);
    return whole_m2 - evaluation::surface_area_m2(surface);
}

mesh::CoverageSettings coverage_settings(const Reconstruction& made) {
    mesh::CoverageSettings settings;
    settings.finest_voxel_m = made.voxels.finest_m;
    settings.coarsest_voxel_m = made.voxels.coarsest_m;
    if (made.options().max_depth_m > 0.0 || made.optimised.max_depth_m > 0.0)
        settings.max_depth_m = made.max_depth_m;
    if (const auto& error = made.surface.simplification) settings.mesh_error_m = 3.0 * error->rms_m;
    return settings;
}

}  // namespace

bool load_mesh(Reconstruction& made, const std::string& key) {
    auto stored = load_surface(made.scratch("mesh.stage"), key);
    if (stored) made.surface = std::move(*stored);
    return stored.has_value();
}

void run_mesh(Reconstruction& made, const base::ProgressCallback& progress) {
    auto [surface, small_components_m2] = mesh(*made.volume, made.options(), progress);
    mesh::finish_sigma(surface, optimisation::shared_sigma_m(made.optimised.statistics.path));
    surface.voxel_m = {};  // not needed any more
    const double cut_m2 = cut_by_sigma(made.options().max_sigma_m, surface);
    made.surface =
        simplified(std::move(surface), made.options(), base::part_of(progress, 1.0, 1.0));
    made.surface.small_components_m2 = small_components_m2;
    made.surface.cut_by_sigma_m2 = cut_m2;
}

void save_mesh(Reconstruction& made, const std::string& key) {
    save_surface(made.scratch("mesh.stage"), key, made.surface);
}

void write_mesh(Reconstruction& made) {
    made.mesh_writer.run([&made] { io::write_ply(made.artifact("mesh.ply"), made.surface.mesh); });
}

void finish_mesh(Reconstruction& made) {
    made.cloud_writer.wait();
    made.volume.reset();
    // The stage after it writes the mesh with its own colours.
    if (!restores_color(made.request.options)) write_mesh(made);
    made.border_finder.run([&made] {
        made.borders = mesh::find_borders(made.surface.mesh);
        made.coverage = mesh::image_coverage(
            made.surface.mesh,
            made.optimised.rig,
            made.optimised.keyframes,
            [&made](int frame_index) { return made.keyframe_store.read_depth(frame_index); },
            coverage_settings(made));
    });
}

}  // namespace divemesh::pipeline
