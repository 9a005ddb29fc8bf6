#include "worker/texture/texture_mesh.hpp"

#include <algorithm>
#include <string>
#include <utility>

#include "schemas/error.hpp"
#include "worker/texture/cut_charts.hpp"
#include "worker/texture/fill_atlases.hpp"
#include "worker/texture/level_seams.hpp"
#include "worker/texture/seam_colors.hpp"
#include "worker/texture/shared_edges.hpp"

namespace divemesh::texture {
namespace {

void check(const types::Mesh& mesh, const FaceViews& views, std::size_t num_keyframes) {
    if (views.size() != mesh.triangles.size())
        throw Error(ErrorCode::InvalidArgument,
                    "there are views for " + std::to_string(views.size()) + " triangles, but " +
                        std::to_string(mesh.triangles.size()) +
                        " triangles: choose the views of this mesh");
    for (const std::int32_t view : views)
        if (view < kNoView || view >= static_cast<std::int64_t>(num_keyframes))
            throw Error(ErrorCode::InvalidArgument,
                        "a triangle is to be seen by keyframe " + std::to_string(view) + " of " +
                            std::to_string(num_keyframes) +
                            ": choose the views of these keyframes");
}

// Returns the views without those of triangles that are not in front of the camera.
FaceViews views_in_front(const types::Mesh& mesh,
                         const FaceViews& views,
                         const Photographs& photographs,
                         int num_threads) {
    FaceViews in_front = views;
    base::for_each_index(num_threads, views.size(), [&](std::size_t i) {
        if (views[i] == kNoView) return;
        for (const std::uint32_t vertex : mesh.triangles[i])
            if (!photographs.pixel(views[i], mesh.vertices[vertex])) in_front[i] = kNoView;
    });
    return in_front;
}

// Sets where each triangle finds its colours in the atlases.
void lay_out(const AtlasSources& sources,
             const AtlasPlan& plan,
             const std::vector<std::uint8_t>& is_filled,
             int num_threads,
             types::Texture& texture) {
    const std::size_t num = sources.mesh.triangles.size();
    texture.atlas_of_triangle.assign(num, types::Texture::kUntextured);
    texture.uv.resize(num);
    base::for_each_index(num_threads, num, [&](std::size_t i) {
        texture.uv[i].fill(Eigen::Vector2f::Zero());
        const std::int32_t cutout = sources.cutouts.of_triangle[i];
        if (cutout == Cutouts::kNone || is_filled[cutout] == 0) return;
        const PlacedCutout& place = plan.places[cutout];
        texture.atlas_of_triangle[i] = place.atlas;
        const cv::Size& size = plan.sizes[place.atlas];
        for (std::size_t k = 0; k < 3; ++k) {
            const Eigen::Vector3f& vertex = sources.mesh.vertices[sources.mesh.triangles[i][k]];
            const Eigen::Vector2d texel =
                place.texel(sources.photographs.pixel(sources.views[i], vertex).value());
            texture.uv[i][k] =
                Eigen::Vector2d((texel.x() + 0.5) / size.width, (texel.y() + 0.5) / size.height)
                    .cast<float>();
        }
    });
}

}  // namespace

types::Texture texture_mesh(const types::Mesh& mesh,
                            const FaceViews& views,
                            const Photographs& photographs,
                            const AtlasOptions& options,
                            int num_threads,
                            const base::ProgressCallback& progress) {
    check(mesh, views, photographs.num_keyframes());
    const std::string stage = "texture";
    FaceViews seen = views_in_front(mesh, views, photographs, num_threads);
    const std::vector<SharedEdge> edges = shared_edges(mesh);
    const SeamColors colors =
        sample_seams(mesh, edges, photographs, num_threads, {stage, 0.0, 0.3, progress}, seen);
    const Levelling levelling =
        level_seams(mesh, seen, colors, photographs.num_keyframes(), {stage, 0.3, 0.6, progress});
    const Cutouts cutouts = cut_charts(mesh, seen, edges, photographs);
    const AtlasPlan plan = pack_cutouts(cutouts.all, options);

    const AtlasSources sources = {mesh, seen, photographs, colors, levelling, cutouts};
    FilledAtlases filled = fill_atlases(sources, plan, num_threads, {stage, 0.6, 1.0, progress});
    types::Texture texture;
    lay_out(sources, plan, filled.is_filled, num_threads, texture);
    texture.atlases = std::move(filled.images);
    texture.texels_per_pixel = plan.texels_per_pixel;
    return texture;
}

}  // namespace divemesh::texture
