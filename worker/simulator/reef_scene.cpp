#include "worker/simulator/reef_parts.hpp"
#include "worker/simulator/scene.hpp"
#include "worker/simulator/scene_parts.hpp"

// The reef scene: spurs of coral rock with sand between them.
namespace divemesh::simulator {
namespace {

constexpr Rectangle kArea = {-7.0F, 7.0F, -5.5F, 5.5F};

void add_ground(SceneBuilder& builder) {
    const NoiseField& noise = builder.noise();
    builder.add("rock",
                Material::Coral,
                make_height_field(
                    kArea, 0.03F, [&](float x, float y) { return reef_rock_height(noise, x, y); }),
                place_at({0, 0, 0}));
    builder.add("sand",
                Material::Sand,
                make_height_field(
                    kArea, 0.035F, [&](float x, float y) { return reef_sand_height(noise, x, y); }),
                place_at({0, 0, 0}));
}

void add_corals(SceneBuilder& builder, base::RandomRow& random) {
    for (int i = 0; i < 130; ++i) {
        const float x = draw(random, -6.3, 6.3);
        const float y = draw(random, -4.8, 4.8);
        add_coral(builder, random, i, x, y);
    }
}

}  // namespace

Scene make_reef_scene(std::uint64_t seed, int year) {
    base::RandomRow random(base::hash64(seed, 0x72656566ULL));
    SceneBuilder builder(seed, year, place_at({0.0F, 0.0F, 0.3F}, 0.1F));
    add_ground(builder);
    add_corals(builder, random);
    const auto on_ground = [&](float x, float y, float yaw) {
        const float z = reef_height(builder.noise(), x, y);
        return place_at({x, y, z + 0.04F}, yaw);
    };
    add_scale_bar(builder, "scale_bar_0", 1.0F, on_ground(-2.0F, 0.6F, 0.3F));
    add_scale_bar(builder, "scale_bar_1", 0.8F, on_ground(1.9F, -0.8F, -0.6F));
    add_scale_bar(builder, "scale_bar_2", 0.8F, on_ground(0.6F, 1.9F, 1.2F));
    add_scale_bar(builder, "scale_bar_3", 0.6F, on_ground(-0.4F, -1.4F, 0.1F));
    add_measured_box(
        builder, "block_0", Material::Rock, {0.3F, 0.3F, 0.2F}, on_ground(2.7F, 0.9F, 0.4F));
    add_measured_box(
        builder, "block_1", Material::Rock, {0.4F, 0.25F, 0.25F}, on_ground(-1.1F, -1.9F, -0.5F));
    SurveyPath path;
    path.center_world = {0.0, 0.0, 1.8};
    path.semi_axis_x_m = 2.7;
    path.semi_axis_y_m = 1.6;
    path.start_angle = -1.6;
    path.look_yaw = 0.2;
    path.look_pitch = 0.78;
    path.speed_m_s = 0.26;
    path.max_scale = 1.4;
    return builder.finish(path, 11.0);
}

}  // namespace divemesh::simulator
