#include "worker/simulator/marine_snow.hpp"

#include <algorithm>
#include <cmath>

#include "worker/base/hashed_random.hpp"
#include "worker/camera/projection.hpp"

namespace divemesh::simulator {
namespace {

// Edge of the cubes in which the water repeats; a camera sees less than half of it.
constexpr double kCube_m = 2.6;
constexpr double kReach_m = 1.2;  // particles farther away are too faint
constexpr double kMinDepth_m = 0.12;
constexpr double kFocus_m = 1.6;
constexpr double kBlur_px = 0.9;  // at half the focus distance, for a lens of 500 px

double wrap(double x) { return x - kCube_m * std::round(x / kCube_m); }

}  // namespace

MarineSnow::MarineSnow(double particles_per_m3, std::uint64_t seed) {
    base::RandomRow random(base::hash64(seed, 0x736e6f77ULL));
    const auto num_particles = static_cast<int>(particles_per_m3 * kCube_m * kCube_m * kCube_m);
    // All particles drift with one current, with small individual deviations, and sink.
    const double current_x = random.uniform(-0.04, 0.04);
    const double current_y = random.uniform(-0.04, 0.04);
    for (int i = 0; i < num_particles; ++i) {
        Particle particle;
        for (int axis = 0; axis < 3; ++axis) particle.start[axis] = random.uniform(0.0, kCube_m);
        particle.drift = {current_x + 0.012 * random.gaussian(),
                          current_y + 0.012 * random.gaussian(),
                          -0.01 + 0.008 * random.gaussian()};
        const double u = random.uniform(0.0, 1.0);
        particle.radius_m = 0.0003 + 0.0014 * u * u * u;  // many small ones, few large ones
        particle.brightness = static_cast<float>(random.uniform(0.3, 1.0));
        particles_.push_back(particle);
    }
}

void MarineSnow::draw(const types::Camera& camera,
                      const Eigen::Isometry3d& T_world_cam,
                      double t_s,
                      const Water& water,
                      Rendering& rendering) const {
    cv::Mat& radiance = rendering.radiance;
    const Eigen::Isometry3d T_cam_world = T_world_cam.inverse();
    const double focal_px = camera::axial_magnification(camera) * camera.fx_px;
    for (const Particle& particle : particles_) {
        const Eigen::Vector3d away =
            particle.start + t_s * particle.drift - T_world_cam.translation();
        const Eigen::Vector3d near(wrap(away.x()), wrap(away.y()), wrap(away.z()));
        const Eigen::Vector3d p_cam = T_cam_world.linear() * near;
        const double range_m = p_cam.norm();
        if (p_cam.z() < kMinDepth_m || range_m > kReach_m) continue;
        const auto pixel = camera::project(camera, p_cam);
        if (!pixel) continue;
        const double sharp_px = focal_px * particle.radius_m / p_cam.z();
        const double blur_px =
            kBlur_px * focal_px / 500.0 * std::abs(1.0 / p_cam.z() - 1.0 / kFocus_m) * kFocus_m;
        const double sigma_px =
            std::sqrt(0.2 + 0.4 * sharp_px * sharp_px + 0.1 * blur_px * blur_px);
        // Blur spreads the light, so it also dims the particle.
        const double area = (0.2 + 0.4 * sharp_px * sharp_px) / (sigma_px * sigma_px);
        const double fade = 1.0 - range_m / kReach_m;
        const auto opacity = static_cast<float>(std::min(
            0.85, 2.5 * area * std::min(1.0, 0.3 + sharp_px) * fade * particle.brightness));
        const Rgb color = (0.4F * (water.ambient + water.sun) +
                           water.strobe / static_cast<float>(0.5 + range_m * range_m))
                              .min(0.9F);
        const int reach = static_cast<int>(std::ceil(3.0 * sigma_px));
        const int u0 = static_cast<int>(std::lround(pixel->x()));
        const int v0 = static_cast<int>(std::lround(pixel->y()));
        for (int v = std::max(0, v0 - reach); v <= std::min(radiance.rows - 1, v0 + reach); ++v)
            for (int u = std::max(0, u0 - reach); u <= std::min(radiance.cols - 1, u0 + reach);
                 ++u) {
                const auto behind = rendering.depth.at<float>(v, u);
                if (behind > 0.0F && behind < static_cast<float>(p_cam.z())) continue;
                const double du = u - pixel->x();
                const double dv = v - pixel->y();
                const auto weight =
                    opacity * static_cast<float>(
                                  std::exp(-0.5 * (du * du + dv * dv) / (sigma_px * sigma_px)));
                auto& value = radiance.at<cv::Vec3f>(v, u);
                for (int c = 0; c < 3; ++c) value[c] += weight * (color[c] - value[c]);
                if (weight > 0.05F) rendering.snow.at<std::uint8_t>(v, u) = 255;
            }
    }
}

}  // namespace divemesh::simulator
