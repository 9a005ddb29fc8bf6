#pragma once

#include <Eigen/Geometry>
#include <array>
#include <atomic>
#include <functional>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <vector>

#include "worker/simulator/fish.hpp"
#include "worker/simulator/lighting.hpp"
#include "worker/simulator/marine_snow.hpp"
#include "worker/simulator/ray_caster.hpp"
#include "worker/simulator/rendering.hpp"
#include "worker/simulator/scene.hpp"
#include "worker/simulator/water.hpp"
#include "worker/types/rig.hpp"

namespace divemesh::simulator {

// The options of an image besides the scene.
struct RenderOptions {
    Water water;
    bool caustics = false;
    std::vector<Fish> fish;
    std::shared_ptr<const MarineSnow> snow;  // null: no snow
    float texture_contrast = 1.0F;           // times that of the materials; 0: one tone each
    bool exact_depth = false;                // else the depth of a ray near the pixel's centre
    std::uint64_t seed = 0;                  // of the textures
};

// Renders a scene through the cameras of a rig, four rays per pixel, refracted where a camera is
// behind a port. Patterns and light are faded
// to what a pixel resolves, so a pixel that shows one smooth patch of surface is shaded once. Uses
// the threads of the calling arena; the result does not depend on their number.
class Renderer {
public:
    // Keeps references to `scene` and `rig`. Takes seconds, in which it calls `check_cancelled` and
    // passes on its exceptions.
    Renderer(
        const Scene& scene,
        const types::Rig& rig,
        RenderOptions options,
        const std::function<void()>& check_cancelled = [] {});

    // Renders camera 0 or 1 with the body at `T_world_imu`, with snow, fish and caustics at time
    // `t_s`.
    Rendering render(int camera, const Eigen::Isometry3d& T_world_imu, double t_s);
    // Renders open water as a camera sees it: the veil, and snow.
    Rendering render_water(int camera, const Eigen::Isometry3d& T_world_imu, double t_s) const;
    // The triangles that all images since construction showed.
    std::vector<bool> seen_triangles() const;
    // Those of them that images of camera 0 showed within kReferenceRange_m.
    static constexpr float kReferenceRange_m = 4.0F;
    std::vector<bool> reference_triangles() const;

private:
    struct Eye;  // one image being rendered
    struct Rays {
        std::vector<RayCaster::Rays4>
            samples;  // camera frame, direction with z = 1, four per pixel
        std::vector<RayCaster::Ray> centers;
    };
    struct Point {
        Eigen::Vector3f p_world;
        Eigen::Vector3f normal_world;
        const SceneObject* object;
        float t;  // depth along the optical axis, m
        float sky;
        float sun;
    };

    void draw_snow(int camera,
                   const Eigen::Isometry3d& T_world_imu,
                   double t_s,
                   Rendering& rendering) const;
    static Rays rays_of(const types::Camera& camera);
    using RayHits4 = std::array<RayHit, 4>;

    void render_row(const Eye& eye, int row, Rendering& rendering);
    void mark_seen(const Eye& eye, const RayHits4& hits, const RayCaster::Rays4& rays);
    std::optional<Fish::Hit> nearest_fish(const Eye& eye,
                                          const cv::Point& pixel,
                                          const RayHit& hit,
                                          const RayCaster::Ray& ray) const;
    // Returns the mean of what the four rays hit, if that is one smooth patch of one object; else
    // nullopt.
    std::optional<Point> one_point(const Eye& eye,
                                   const RayHits4& hits,
                                   const RayCaster::Rays4& rays) const;
    Rgb sample(const Eye& eye,
               const RayHit& hit,
               const RayCaster::Ray& ray,
               const Fish::Hit* fish,
               Rgb& albedo) const;
    // Returns the light from a point of the scene as seen, and its own colour in `albedo`.
    Rgb look_at(const Eye& eye, const Point& point, Rgb& albedo) const;
    Rgb albedo_of(const Point& point, float footprint_m) const;
    Point point_at(const RayHit& hit, const RayCaster::Ray& ray) const;
    Rgb shade(const Eye& eye, const Point& point, const Rgb& color, float footprint_m) const;

    const Scene& scene_;
    const types::Rig& rig_;
    RenderOptions options_;
    RayCaster caster_;
    NoiseField noise_;
    Eigen::Vector3f to_sun_;
    BakedLight light_;
    std::array<Rays, 2> rays_;
    // Whether an image showed a triangle, and whether camera 0 did within the range of the
    // reference.
    std::vector<std::atomic<bool>> seen_;
    std::vector<std::atomic<bool>> in_reference_;
};

}  // namespace divemesh::simulator
