#include "worker/mesh/extract_surface.hpp"

#include <utility>

#include "worker/mesh/marching_cubes.hpp"
#include "worker/mesh/mesh_components.hpp"
#include "worker/mesh/smooth_membrane.hpp"
#include "worker/mesh/surface_nets.hpp"

namespace divemesh::mesh {
namespace {

constexpr double kMinComponent_voxels = 100.0;  // faces of a voxel

}  // namespace

ExtractedSurface extract_surface(const fusion::Volume& volume,
                                 const std::string& mesher,
                                 int num_threads,
                                 const base::ProgressCallback& progress) {
    base::ProgressShare share{.report = progress};
    share.at(0.0);
    const auto field = volume.field(num_threads);
    share.begin = 0.2;
    share.end = 0.95;
    const MeshingSettings settings{.num_threads = num_threads, .progress = share};
    types::Mesh whole = mesher == "marching_cubes" ? marching_cubes(*field, settings)
                                                   : surface_nets(*field, settings);
    LargeComponents surface = keep_large_components(std::move(whole), kMinComponent_voxels);
    smooth_membrane(surface.mesh, num_threads);
    return {std::move(surface.mesh), surface.removed_m2};
}

}  // namespace divemesh::mesh
