#include "worker/simulator/scene_parts.hpp"

namespace divemesh::simulator {
namespace {

constexpr float kFineStep_m = 0.02F;
constexpr float kBarWidth_m = 0.06F;
constexpr float kBarHeight_m = 0.05F;

}  // namespace

void add_measured_box(SceneBuilder& builder,
                      const std::string& name,
                      Material material,
                      const Eigen::Vector3f& size_m,
                      const Eigen::Isometry3f& T_place_box) {
    const Eigen::Vector3f half = 0.5F * size_m;
    Shape shape = make_box(size_m, kFineStep_m);
    for (Eigen::Vector3f& p : shape.vertices) p.z() += half.z();
    builder.add(name, material, shape, T_place_box);
    const auto corner = [&](float x, float y, float z) -> Eigen::Vector3d {
        return (T_place_box * Eigen::Vector3f(x * half.x(), y * half.y(), z)).cast<double>();
    };
    const Eigen::Vector3d origin = corner(1.0F, -1.0F, size_m.z());
    builder.add_distance(
        name + "_length", "top edge along x", corner(-1.0F, -1.0F, size_m.z()), origin);
    builder.add_distance(
        name + "_width", "top edge along y", origin, corner(1.0F, 1.0F, size_m.z()));
    builder.add_distance(name + "_height", "vertical edge", corner(1.0F, -1.0F, 0.0F), origin);
}

void add_scale_bar(SceneBuilder& builder,
                   const std::string& name,
                   float length_m,
                   const Eigen::Isometry3f& T_place_bar) {
    const Eigen::Isometry3f T_place_middle =
        T_place_bar * place_at({0.0F, 0.0F, 0.5F * kBarHeight_m});
    builder.add(name,
                Material::ScaleBar,
                make_box({length_m, kBarWidth_m, kBarHeight_m}, kFineStep_m),
                T_place_middle);
    const auto end = [&](float side) -> Eigen::Vector3d {
        const Eigen::Vector3f p(side * 0.5F * length_m, 0.0F, 0.5F * kBarHeight_m);
        return (T_place_middle * p).cast<double>();
    };
    builder.add_distance(
        name + "_length", "middles of the end edges of the top face", end(-1.0F), end(1.0F));
}

void add_lump(SceneBuilder& builder,
              const std::string& name,
              Material material,
              float radius_m,
              const Eigen::Isometry3f& T_place_lump) {
    Shape shape = make_ellipsoid({radius_m, 0.9F * radius_m, 0.8F * radius_m}, 0.022F);
    roughen(shape, builder.noise(), 0.12F * radius_m, 0.8F * radius_m);
    roughen(shape, builder.noise(), 0.008F, 0.04F);
    builder.add(name, material, shape, T_place_lump);
}

}  // namespace divemesh::simulator
