#include "worker/texture/face_views.hpp"

#include <algorithm>
#include <cstddef>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "schemas/error.hpp"
#include "worker/base/parallel.hpp"
#include "worker/stats/median.hpp"
#include "worker/texture/collect_views.hpp"
#include "worker/texture/merge_charts.hpp"
#include "worker/texture/photo_consistency.hpp"
#include "worker/texture/smooth_views.hpp"
#include "worker/texture/water_light.hpp"
#include "worker/types/triangle_area.hpp"

namespace divemesh::texture {
namespace {

constexpr double kSeamWidth_px = 16.0;

void check_sizes(std::size_t num_triangles, std::size_t num_keyframes) {
    constexpr std::size_t kMaxTriangles = 500'000'000;  // six links of each have 32-bit indices
    constexpr std::size_t kMaxKeyframes = std::numeric_limits<std::uint16_t>::max();
    if (num_triangles > kMaxTriangles)
        throw Error(ErrorCode::TooLarge,
                    "texture: the mesh has " + std::to_string(num_triangles) +
                        " triangles, more than 500,000,000: simplify it first");
    if (num_keyframes > kMaxKeyframes)
        throw Error(ErrorCode::TooLarge,
                    "texture: the dive has " + std::to_string(num_keyframes) +
                        " keyframes, more than 65,535: split it");
}

// Returns the width of a pixel of the best candidate on the surface; the median of the triangles.
double pixel_m(const SeenMesh& seen, double focal_px) {
    std::vector<double> ranges_m;
    for (std::size_t face = 0; face < seen.candidates.num_faces(); ++face) {
        const auto views = seen.candidates.of(face);
        if (views.empty()) continue;
        const auto best = std::max_element(
            views.begin(), views.end(), [](const Candidate& a, const Candidate& b) {
                return a.quality < b.quality;
            });
        ranges_m.push_back(static_cast<double>(seen.range_m(face, *best)));
    }
    return stats::median(std::move(ranges_m)) / focal_px;
}

std::vector<float> areas_m2(const types::Mesh& mesh) {
    std::vector<float> areas(mesh.triangles.size());
    for (std::size_t face = 0; face < areas.size(); ++face)
        areas[face] = static_cast<float>(types::triangle_area_m2(mesh, mesh.triangles[face]));
    return areas;
}

}  // namespace

ChosenFaceViews choose_face_views(const types::Mesh& mesh,
                                  const types::RectifiedRig& rig,
                                  const std::vector<types::Keyframe>& keyframes,
                                  const keyframes::ReadImage& read_image,
                                  int num_threads,
                                  const base::ProgressCallback& progress) {
    check_sizes(mesh.triangles.size(), keyframes.size());
    auto [candidates, lost_frames] =
        collect_views(mesh, rig, keyframes, read_image, num_threads, {"", 0.0, 0.6, progress});
    const FaceGraph graph(mesh);
    drop_inconsistent_views(
        mesh, keyframes, graph, num_threads, {"", 0.6, 0.7, progress}, candidates);
    const double seam_m = kSeamWidth_px * pixel_m({mesh, keyframes, candidates}, rig.focal_px);
    const ViewField field{candidates, graph, areas_m2(mesh), static_cast<float>(seam_m)};
    FaceViews views = smooth_views(field, num_threads, {"", 0.7, 1.0, progress});
    merge_charts(field, views);
    descend(field, num_threads, views);
    return {std::move(views), std::move(lost_frames)};
}

}  // namespace divemesh::texture
