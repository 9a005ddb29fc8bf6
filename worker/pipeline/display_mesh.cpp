#include "worker/pipeline/display_mesh.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "worker/base/parallel.hpp"
#include "worker/base/part_of.hpp"
#include "worker/mesh/simplify_within.hpp"
#include "worker/mesh/split_long_edges.hpp"
#include "worker/pipeline/simplification_error.hpp"
#include "worker/stats/ratio.hpp"
#include "worker/texture/face_views.hpp"
#include "worker/texture/texture_mesh.hpp"
#include "worker/types/triangle_area.hpp"

namespace divemesh::pipeline {
namespace {

constexpr float kMaxError_sigmas = 0.5F;
// A keyframe textures a triangle that it shows all of, so that large ones would stay without a
// photograph though many show their parts.
constexpr float kMaxEdge_px = 48.0F;
constexpr float kMinRange_m = 0.2F;  // surface nearer than that to a camera is an error
// Shares of the work that are done.
constexpr double kSimplified = 0.3;
constexpr double kMeasured = 0.4;
constexpr double kChosen = 0.7;

types::Mesh simplified(const types::Mesh& surface,
                       int num_threads,
                       const base::ProgressCallback& progress) {
    std::vector<float> tolerance_m = surface.sigma_m;
    for (float& tolerance : tolerance_m) tolerance *= kMaxError_sigmas;
    return mesh::simplify_within(surface, tolerance_m, num_threads, progress);
}

// Returns for each vertex the length of kMaxEdge_px pixels at the range of the nearest keyframe.
std::vector<float> max_edges_m(const types::Mesh& mesh,
                               const types::RectifiedRig& rig,
                               const std::vector<types::Keyframe>& keyframes,
                               int num_threads) {
    std::vector<Eigen::Vector3f> positions_world;
    for (const types::Keyframe& keyframe : keyframes)
        positions_world.emplace_back(keyframe.T_world_cam.translation().cast<float>());
    std::vector<float> edges_m(mesh.vertices.size());
    base::for_each_index(num_threads, edges_m.size(), [&](std::size_t i) {
        float nearest_m2 = std::numeric_limits<float>::infinity();
        for (const Eigen::Vector3f& position : positions_world)
            nearest_m2 = std::min(nearest_m2, (mesh.vertices[i] - position).squaredNorm());
        edges_m[i] = kMaxEdge_px / static_cast<float>(rig.focal_px) *
                     std::max(kMinRange_m, std::sqrt(nearest_m2));
    });
    return edges_m;
}

double textured_share(const types::Mesh& mesh, const types::Texture& texture) {
    double textured_m2 = 0.0;
    double whole_m2 = 0.0;
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
        const double area_m2 = types::triangle_area_m2(mesh, mesh.triangles[i]);
        whole_m2 += area_m2;
        if (texture.atlas_of_triangle[i] != types::Texture::kUntextured) textured_m2 += area_m2;
    }
    return stats::ratio(textured_m2, whole_m2);
}

}  // namespace

DisplayMesh make_display_mesh(const types::Mesh& surface,
                              const types::RectifiedRig& rig,
                              const std::vector<types::Keyframe>& keyframes,
                              const keyframes::ReadImage& recorded,
                              const keyframes::ReadImage& shown,
                              int num_threads,
                              const base::ProgressCallback& progress) {
    DisplayMesh result{
        simplified(surface, num_threads, base::part_of(progress, 0.0, kSimplified)), {}, {}};
    std::vector<float> max_m = max_edges_m(result.mesh, rig, keyframes, num_threads);
    result.mesh = mesh::split_long_edges(std::move(result.mesh), std::move(max_m));
    TextureMetrics& metrics = result.metrics;
    metrics.num_triangles = std::ssize(result.mesh.triangles);
    metrics.simplification = simplification_error(
        surface, result.mesh, num_threads, base::part_of(progress, kSimplified, kMeasured));
    const texture::ChosenFaceViews chosen =
        texture::choose_face_views(result.mesh,
                                   rig,
                                   keyframes,
                                   recorded,
                                   num_threads,
                                   base::part_of(progress, kMeasured, kChosen));
    result.texture = texture::texture_mesh(result.mesh,
                                           chosen.face_views,
                                           {rig, keyframes, shown},
                                           {},
                                           num_threads,
                                           base::part_of(progress, kChosen, 1.0));
    metrics.lost_frames = chosen.lost_frames;
    metrics.num_atlases = std::ssize(result.texture.atlases);
    metrics.texels_per_pixel = result.texture.texels_per_pixel;
    metrics.textured_share = textured_share(result.mesh, result.texture);
    return result;
}

}  // namespace divemesh::pipeline
