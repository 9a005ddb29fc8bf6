#include "worker/simulator/lighting.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include "worker/base/hashed_random.hpp"

namespace divemesh::simulator {
namespace {

constexpr int kSkyRays = 12;
constexpr float kSkyReach_m = 1.2F;  // geometry farther away does not darken
constexpr float kOffset_m = 2e-3F;
constexpr std::size_t kVerticesAtOnce = 16384;  // takes about 50 ms

// Returns the visible share of the sky; directions are cosine-weighted over the half space of
// `normal` (golden-angle spiral).
float sky_at(const RayCaster& caster,
             const Eigen::Vector3f& p,
             const Eigen::Vector3f& normal,
             double rotation) {
    const Eigen::Vector3f side = normal.unitOrthogonal();
    const Eigen::Vector3f other = normal.cross(side);
    int open = 0;
    for (int i = 0; i < kSkyRays; ++i) {
        const double r2 = (i + 0.5) / kSkyRays;
        const double angle = 2.39996323 * i + rotation;
        const auto x = static_cast<float>(std::sqrt(r2) * std::cos(angle));
        const auto y = static_cast<float>(std::sqrt(r2) * std::sin(angle));
        const auto z = static_cast<float>(std::sqrt(1.0 - r2));
        const Eigen::Vector3f direction = x * side + y * other + z * normal;
        open += caster.is_blocked(p + kOffset_m * normal, direction, kSkyReach_m) ? 0 : 1;
    }
    return static_cast<float>(open) / kSkyRays;
}

// Averages a value over neighbouring vertices, to remove the noise of few rays.
void smooth(const Scene& scene, std::vector<float>& values) {
    std::vector<float> sums(values.size(), 0.0F);
    std::vector<float> weights(values.size(), 0.0F);
    for (const auto& t : scene.triangles) {
        const float mean = (values[t[0]] + values[t[1]] + values[t[2]]) / 3.0F;
        for (const std::uint32_t vertex : t) {
            sums[vertex] += mean;
            weights[vertex] += 1.0F;
        }
    }
    for (std::size_t i = 0; i < values.size(); ++i)
        if (weights[i] > 0.0F) values[i] = sums[i] / weights[i];
}

}  // namespace

BakedLight::BakedLight(const Scene& scene,
                       const RayCaster& caster,
                       const Eigen::Vector3f& to_sun,
                       const std::function<void()>& check_cancelled)
    : sky_(scene.vertices.size()), sun_(scene.vertices.size()) {
    const auto bake = [&](std::size_t i) {
        const Eigen::Vector3f& p = scene.vertices[i];
        const Eigen::Vector3f& normal = scene.normals[i];
        const double rotation = 2.0 * std::numbers::pi * base::to_unit(base::hash64(i));
        sky_[i] = sky_at(caster, p, normal, rotation);
        const bool shadow =
            normal.dot(to_sun) <= 0.0F || caster.is_blocked(p + kOffset_m * normal, to_sun, 50.0F);
        sun_[i] = shadow ? 0.0F : 1.0F;
    };
    for (std::size_t start = 0; start < scene.vertices.size(); start += kVerticesAtOnce) {
        check_cancelled();
        const std::size_t end = std::min(scene.vertices.size(), start + kVerticesAtOnce);
        tbb::parallel_for(tbb::blocked_range<std::size_t>(start, end, 1024),
                          [&](const auto& range) {
                              for (std::size_t i = range.begin(); i < range.end(); ++i) bake(i);
                          });
    }
    smooth(scene, sky_);
    smooth(scene, sun_);
}

float caustic(const NoiseField& noise,
              const Eigen::Vector3f& p_world,
              const Eigen::Vector3f& to_sun,
              float t_s,
              float footprint_m) {
    const Eigen::Vector2f at =
        p_world.head<2>() -
        p_world.z() / to_sun.z() * to_sun.head<2>();  // projected along the sun's rays
    constexpr float kMesh_m = 0.34F;
    const Eigen::Array4f bend = noise.at({at.x() * 1.7F, at.y() * 1.7F, 1.1F * t_s});
    const Eigen::Array4f net = noise.at(
        {at.x() / kMesh_m + 0.55F * bend[0], at.y() / kMesh_m + 0.55F * bend[1], 1.9F * t_s});
    const auto line = [](float n) {
        const float ridge = 1.0F - std::min(1.0F, 2.4F * std::abs(n));
        return ridge * ridge * ridge;
    };
    const float detail = band_limit(0.25F * kMesh_m, footprint_m);
    return 0.45F + detail * 1.7F * (line(net[0]) + line(net[1])) + (1.0F - detail) * 0.55F;
}

}  // namespace divemesh::simulator
