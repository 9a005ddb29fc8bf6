#include <utility>
#include <vector>

#include "worker/color/fit_water.hpp"
#include "worker/color/restore_vertices.hpp"
#include "worker/color/surface_sightings.hpp"
#include "worker/pipeline/stage_files.hpp"
#include "worker/pipeline/stage_functions.hpp"

namespace divemesh::pipeline {
namespace {

constexpr const char* kStage = "color";
constexpr double kSeen = 0.4;  // share of the work that is done
constexpr double kFitted = 0.6;

}  // namespace

bool color_wanted(const Reconstruction& made) {
    return restores_color(made.options()) && surface_wanted(made);
}

bool load_color(Reconstruction& made, const std::string& key) {
    auto stored = load_water_color(made.scratch("color.stage"), key);
    if (stored) made.color = std::move(*stored);
    return stored.has_value();
}

void run_color(Reconstruction& made, const base::ProgressCallback& progress) {
    const color::SeenSurface surface(made.surface.mesh, made.optimised.rig);
    const auto read = [&made](int frame_index) { return made.keyframe_store.read(frame_index); };
    const int num_threads = made.options().num_threads;
    const std::vector<types::Keyframe>& keyframes = made.optimised.keyframes;
    const color::Sightings sightings = color::surface_sightings(
        surface, keyframes, read, num_threads, {kStage, 0.0, kSeen, progress});
    WaterColor water{
        .fit = color::fit_water(sightings, num_threads, {kStage, kSeen, kFitted, progress}),
        .num_lost_images = static_cast<std::int64_t>(sightings.num_lost_images)};
    if (water.fit.is_known()) {
        const auto relative = white_point_of(made.options());
        water.white = relative ? color::white_point_like(*relative, water.fit.surface)
                               : color::white_point_of(water.fit.surface);
        color::RestoredVertices restored =
            color::restore_vertices(surface,
                                    keyframes,
                                    read,
                                    color::Restorer(water.fit, water.white),
                                    num_threads,
                                    {kStage, kFitted, 1.0, progress});
        water.vertices = std::move(restored.colors);
        water.limited_share = restored.limited_share;
    }
    made.color = std::move(water);
}

void save_color(Reconstruction& made, const std::string& key) {
    save_water_color(made.scratch("color.stage"), key, *made.color);
}

void finish_color(Reconstruction& made) {
    if (made.color->fit.is_known()) made.surface.mesh.colors = std::move(made.color->vertices);
    write_mesh(made);
}

}  // namespace divemesh::pipeline
