#include <algorithm>
#include <array>
#include <cmath>

#include "worker/simulator/scene.hpp"
#include "worker/simulator/scene_parts.hpp"

// Spurs of coral rock with sand between them.
namespace divemesh::worker {
namespace {

constexpr Rectangle kArea = {-7.0F, 7.0F, -5.5F, 5.5F};

float rock_height(const NoiseField& noise, float x, float y) {
    const Eigen::Vector3f p(x, y, 0.0F);
    const Eigen::Array4f wide = noise.fractal(p, 2.6F, 3);
    const Eigen::Array4f lumps = noise.fractal(p, 0.55F, 3);
    const Eigen::Array4f rough = noise.fractal(p, 0.13F, 2);
    const float spur = 0.16F * std::sin(1.7F * x + 0.8F * y + 1.2F * wide[1]);
    return 0.22F * wide[0] + spur + 0.13F * std::abs(lumps[0]) + 0.028F * rough[2];
}

float sand_height(const NoiseField& noise, float x, float y) {
    const Eigen::Vector3f p(x, y, 3.0F);
    const float ripple = std::sin(30.0F * (0.5F * x + y + 0.1F * noise.at(p)[1]));
    return -0.12F + 0.05F * noise.fractal(p, 1.9F, 2)[0] + 0.01F * ripple;
}

float ground_height(const NoiseField& noise, float x, float y) {
    return std::max(rock_height(noise, x, y), sand_height(noise, x, y));
}

void add_ground(SceneBuilder& builder) {
    const NoiseField& noise = builder.noise();
    builder.add(
        "rock",
        Material::Coral,
        make_height_field(kArea, 0.03F, [&](float x, float y) { return rock_height(noise, x, y); }),
        place_at({0, 0, 0}));
    builder.add("sand",
                Material::Sand,
                make_height_field(
                    kArea, 0.035F, [&](float x, float y) { return sand_height(noise, x, y); }),
                place_at({0, 0, 0}));
}

// A plate on a stalk: what hangs over is hidden from above.
Shape make_table_coral(const SceneBuilder& builder, float radius_m) {
    Shape shape = make_ellipsoid({radius_m, radius_m, 0.16F * radius_m}, 0.02F);
    for (Eigen::Vector3f& p : shape.vertices)
        p.z() += 0.9F * radius_m + 0.25F * p.head<2>().squaredNorm() / radius_m;
    Shape stalk = make_cylinder(0.3F * radius_m, 0.9F * radius_m, 0.025F);
    append(shape, stalk);
    roughen(shape, builder.noise(), 0.05F * radius_m, 0.5F * radius_m);
    roughen(shape, builder.noise(), 0.006F, 0.035F);
    return shape;
}

Shape make_head(const SceneBuilder& builder, float radius_m) {
    Shape shape = make_ellipsoid({radius_m, radius_m, 0.85F * radius_m}, 0.022F);
    for (Eigen::Vector3f& p : shape.vertices) p.z() += 0.45F * radius_m;
    roughen(shape, builder.noise(), 0.16F * radius_m, 0.9F * radius_m);
    roughen(shape, builder.noise(), 0.008F, 0.04F);
    return shape;
}

void add_corals(SceneBuilder& builder, RandomRow& random) {
    for (int i = 0; i < 130; ++i) {
        const float x = draw(random, -6.3, 6.3);
        const float y = draw(random, -4.8, 4.8);
        const float size_m = draw(random, 0.09, 0.3);
        const float yaw = draw(random, -3.1, 3.1);
        const float tilt = draw(random, -0.2, 0.2);
        Shape shape;
        Material material = Material::Coral;
        switch (i % 4) {
            case 0: shape = make_head(builder, size_m); break;
            case 1: shape = make_table_coral(builder, 0.9F * size_m); break;
            case 2:
                shape = make_branches(1.3F * size_m, 7, 0.016F, hash64(builder.seed(), 78, i));
                material = Material::BranchCoral;
                break;
            default:
                shape = make_cylinder(0.28F * size_m, 1.3F * size_m, 0.02F);
                roughen(shape, builder.noise(), 0.1F * size_m, 0.3F);
                material = Material::Sponge;
                break;
        }
        const float z = ground_height(builder.noise(), x, y) - 0.03F;
        const auto T = place_at({x, y, z}, yaw, tilt);
        const std::string name = "coral_" + std::to_string(i);
        constexpr std::array<SceneBuilder::Fate, 3> kFates = {
            SceneBuilder::Fate::Grows, SceneBuilder::Fate::Lost, SceneBuilder::Fate::New};
        if (i % 5 == 0)
            builder.add_changing(
                name, material, shape, T, kFates[static_cast<std::size_t>(i / 5 % 3)]);
        else
            builder.add(name, material, shape, T);
    }
}

}  // namespace

Scene make_reef_scene(std::uint64_t seed, int year) {
    RandomRow random(hash64(seed, 0x72656566ULL));
    SceneBuilder builder(seed, year, place_at({0.0F, 0.0F, 0.3F}, 0.1F));
    add_ground(builder);
    add_corals(builder, random);
    const auto on_ground = [&](float x, float y, float yaw) {
        const float z = ground_height(builder.noise(), x, y);
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

}  // namespace divemesh::worker
