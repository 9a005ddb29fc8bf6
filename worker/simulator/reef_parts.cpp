#include "worker/simulator/reef_parts.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "worker/simulator/scene_parts.hpp"

namespace divemesh::simulator {
namespace {

// Returns a plate on a stalk; what it overhangs is hidden from above.
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

}  // namespace

float reef_rock_height(const NoiseField& noise, float x, float y) {
    const Eigen::Vector3f p(x, y, 0.0F);
    const Eigen::Array4f wide = noise.fractal(p, 2.6F, 3);
    const Eigen::Array4f lumps = noise.fractal(p, 0.55F, 3);
    const Eigen::Array4f rough = noise.fractal(p, 0.13F, 2);
    const float spur = 0.16F * std::sin(1.7F * x + 0.8F * y + 1.2F * wide[1]);
    return 0.22F * wide[0] + spur + 0.13F * std::abs(lumps[0]) + 0.028F * rough[2];
}

float reef_sand_height(const NoiseField& noise, float x, float y) {
    const Eigen::Vector3f p(x, y, 3.0F);
    const float ripple = std::sin(30.0F * (0.5F * x + y + 0.1F * noise.at(p)[1]));
    return -0.12F + 0.05F * noise.fractal(p, 1.9F, 2)[0] + 0.01F * ripple;
}

float reef_height(const NoiseField& noise, float x, float y) {
    return std::max(reef_rock_height(noise, x, y), reef_sand_height(noise, x, y));
}

void add_coral(SceneBuilder& builder, base::RandomRow& random, int number, float x, float y) {
    const float size_m = draw(random, 0.09, 0.3);
    const float yaw = draw(random, -3.1, 3.1);
    const float tilt = draw(random, -0.2, 0.2);
    Shape shape;
    Material material = Material::Coral;
    switch (number % 4) {
        case 0: shape = make_head(builder, size_m); break;
        case 1: shape = make_table_coral(builder, 0.9F * size_m); break;
        case 2:
            shape =
                make_branches(1.3F * size_m, 7, 0.016F, base::hash64(builder.seed(), 78, number));
            material = Material::BranchCoral;
            break;
        default:
            shape = make_cylinder(0.28F * size_m, 1.3F * size_m, 0.02F);
            roughen(shape, builder.noise(), 0.1F * size_m, 0.3F);
            material = Material::Sponge;
            break;
    }
    const float z = reef_height(builder.noise(), x, y) - 0.03F;
    const auto T = place_at({x, y, z}, yaw, tilt);
    const std::string name = "coral_" + std::to_string(number);
    constexpr std::array<SceneBuilder::Fate, 3> kFates = {
        SceneBuilder::Fate::Grows, SceneBuilder::Fate::Lost, SceneBuilder::Fate::New};
    if (number % 5 == 0)
        builder.add_changing(
            name, material, shape, T, kFates[static_cast<std::size_t>(number / 5 % 3)]);
    else
        builder.add(name, material, shape, T);
}

}  // namespace divemesh::simulator
