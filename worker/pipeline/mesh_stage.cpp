#include "worker/io/ply.hpp"
#include "worker/mesh/cut_by_sigma.hpp"
#include "worker/mesh/vertex_sigma.hpp"
#include "worker/optimisation/expected_path_error.hpp"
#include "worker/pipeline/simplification_error.hpp"
#include "worker/pipeline/stage_files.hpp"
#include "worker/pipeline/stage_functions.hpp"

namespace divemesh::pipeline {
namespace {

constexpr int kNumCoverageImages = 10;

Surface simplified(types::Mesh mesh, const ReconstructionOptions& options) {
    if (options.simplify >= 1.0 || mesh.triangles.empty()) return {std::move(mesh), std::nullopt};
    types::Mesh fewer = mesh::simplify_mesh(mesh, {options.simplify, options.simplify_error_m});
    const auto error = simplification_error(mesh, fewer, options.num_threads);
    return {std::move(fewer), error};
}

}  // namespace

bool load_mesh(Reconstruction& made, const std::string& key) {
    auto stored = load_surface(made.scratch("mesh.stage"), key);
    if (stored) made.surface = std::move(*stored);
    return stored.has_value();
}

void run_mesh(Reconstruction& made, const base::ProgressCallback& progress) {
    types::Mesh surface = mesh(*made.volume, made.options(), progress);
    mesh::finish_sigma(surface, optimisation::shared_sigma_m(made.optimised.statistics.path));
    surface.voxel_m = {};  // not needed any more
    if (const double limit_m = made.options().max_sigma_m; limit_m > 0.0)
        surface = mesh::cut_by_sigma(std::move(surface), limit_m);
    made.surface = simplified(std::move(surface), made.options());
}

void save_mesh(Reconstruction& made, const std::string& key) {
    save_surface(made.scratch("mesh.stage"), key, made.surface);
}

void finish_mesh(Reconstruction& made) {
    made.cloud_writer.wait();
    made.volume.reset();
    made.mesh_writer.run([&made] { io::write_ply(made.artifact("mesh.ply"), made.surface.mesh); });
    made.border_finder.run([&made] {
        made.borders = mesh::find_borders(made.surface.mesh);
        made.coverage = mesh::image_coverage(
            made.surface.mesh, made.optimised.rig, made.optimised.keyframes, kNumCoverageImages);
    });
}

}  // namespace divemesh::pipeline
