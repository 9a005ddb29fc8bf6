#include "worker/pipeline/display_mesh.hpp"

#include "worker/base/part_of.hpp"
#include "worker/mesh/simplify_within.hpp"
#include "worker/pipeline/simplification_error.hpp"
#include "worker/stats/ratio.hpp"
#include "worker/texture/face_views.hpp"
#include "worker/texture/texture_mesh.hpp"
#include "worker/types/triangle_area.hpp"

namespace divemesh::pipeline {
namespace {

constexpr float kMaxError_sigmas = 0.5F;
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
                              const keyframes::ReadImage& read_image,
                              int num_threads,
                              const base::ProgressCallback& progress) {
    DisplayMesh result{
        simplified(surface, num_threads, base::part_of(progress, 0.0, kSimplified)), {}, {}};
    TextureMetrics& metrics = result.metrics;
    metrics.num_triangles = std::ssize(result.mesh.triangles);
    metrics.simplification = simplification_error(
        surface, result.mesh, num_threads, base::part_of(progress, kSimplified, kMeasured));
    const texture::ChosenFaceViews chosen =
        texture::choose_face_views(result.mesh,
                                   rig,
                                   keyframes,
                                   read_image,
                                   num_threads,
                                   base::part_of(progress, kMeasured, kChosen));
    result.texture = texture::texture_mesh(result.mesh,
                                           chosen.face_views,
                                           {rig, keyframes, read_image},
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
