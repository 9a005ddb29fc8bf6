#include <numbers>

#include "worker/simulator/scene.hpp"

// The bed scene: an empty plane of sand and gravel, which shows how a wrong calibration bends the
// model.
namespace divemesh::simulator {

Scene make_bed_scene(std::uint64_t seed, int year) {
    SceneBuilder builder(seed, year, place_at({0.0F, 0.0F, 0.0F}));
    builder.add(
        "bed",
        Material::Coral,
        make_height_field({-9.0F, 9.0F, -5.0F, 5.0F}, 0.1F, [](float, float) { return 0.0F; }),
        place_at({0, 0, 0}));
    // Almost straight along x, and so low that the visible strip is narrow compared with the path's
    // length: this shows the bend of the path, not that of each image.
    SurveyPath path;
    path.center_world = {0.0, -40.0, 1.0};
    path.semi_axis_x_m = 40.0;
    path.semi_axis_y_m = 40.0;
    path.start_angle = std::numbers::pi / 2.0 - 0.1;
    path.look_pitch = 1.1;
    path.speed_m_s = 0.25;
    path.max_scale = 1.0;
    return builder.finish(path, 6.0);
}

}  // namespace divemesh::simulator
