#include "worker/simulator/renderer.hpp"

#include <algorithm>
#include <cmath>
#include <tbb/parallel_for.h>

#include "worker/camera/projection.hpp"

namespace divemesh::simulator {
namespace {

// The directions of a pixel's four rays: a rotated grid about its centre.
constexpr std::array<std::array<double, 2>, 4> kSubpixels = {
    {{-0.375, -0.125}, {0.125, -0.375}, {0.375, 0.125}, {-0.125, 0.375}}};

// Lamps on arms at both sides of the rig, in the frame of cam0.
const std::array<Eigen::Vector3d, 2> kLamps_cam0 = {Eigen::Vector3d(-0.45, -0.25, -0.05),
                                                    Eigen::Vector3d(0.58, -0.25, -0.05)};

// Within a pixel a surface is one patch if its normals differ by less than 11 degrees and its
// depth, in footprints of the pixel, by less than on a slope of 80 degrees.
constexpr float kSmoothCosine = 0.98F;
constexpr float kSmoothSlope = 6.0F;

// A pixel of this size resolves no pattern of any material.
constexpr float kNoPattern_m = 1000.0F;

cv::Vec3f to_vec(const Rgb& color) { return {color[0], color[1], color[2]}; }

// Returns the ray of a pixel in the frame of its camera, from the depth 0 on: behind a port that is
// a line through the water that is extended to there, so that lengths along it are depths.
RayCaster::Ray ray_of(const types::Camera& camera, const Eigen::Vector2d& pixel) {
    const base::Ray ray = camera::sight_ray(camera, pixel);
    return {(ray.origin - ray.origin.z() * ray.direction).cast<float>(),
            ray.direction.cast<float>()};
}

Rendering empty_rendering(const types::Camera& camera) {
    const cv::Size size(camera.width_px, camera.height_px);
    return {cv::Mat::zeros(size, CV_32FC3),
            cv::Mat::zeros(size, CV_32F),
            cv::Mat::zeros(size, CV_32FC3),
            cv::Mat::zeros(size, CV_8U),
            cv::Mat::zeros(size, CV_8U)};
}

}  // namespace

struct Renderer::Eye {
    RayCaster::Ray in_world(const RayCaster::Ray& ray_cam) const {
        return {center_world + R_world_cam * ray_cam.origin, R_world_cam * ray_cam.direction};
    }

    int camera;
    const Rays* rays;
    Eigen::Matrix3f R_world_cam;
    Eigen::Vector3f center_world;
    float pixel_size;  // size of a pixel at 1 m
    float t_s;
    std::array<Eigen::Vector3f, 2> lamps_world;
    struct VisibleFish {
        Fish::Shape shape;
        cv::Rect box;
    };
    std::vector<VisibleFish> fish;
};

Renderer::Renderer(const Scene& scene,
                   const types::Rig& rig,
                   RenderOptions options,
                   const std::function<void()>& check_cancelled)
    : scene_(scene),
      rig_(rig),
      options_(std::move(options)),
      caster_(scene.vertices, scene.triangles),
      noise_(texture_noise(options_.seed)),
      to_sun_(Eigen::Vector3f(0.35F, -0.22F, 0.9F).normalized()),
      light_(scene, caster_, to_sun_, check_cancelled),
      seen_(scene.triangles.size()),
      in_reference_(scene.triangles.size()) {
    for (std::size_t c = 0; c < rays_.size(); ++c) {
        check_cancelled();
        rays_[c] = rays_of(c == 0 ? rig.cam0 : rig.cam1);
    }
}

Renderer::Rays Renderer::rays_of(const types::Camera& camera) {
    Rays rays;
    const auto num_pixels = static_cast<std::size_t>(camera.width_px) * camera.height_px;
    rays.samples.resize(num_pixels);
    rays.centers.resize(num_pixels);
    tbb::parallel_for(0, camera.height_px, [&](int v) {
        for (int u = 0; u < camera.width_px; ++u) {
            const std::size_t pixel = static_cast<std::size_t>(v) * camera.width_px + u;
            for (std::size_t i = 0; i < kSubpixels.size(); ++i)
                rays.samples[pixel][i] =
                    ray_of(camera, {u + kSubpixels[i][0], v + kSubpixels[i][1]});
            rays.centers[pixel] = ray_of(camera, Eigen::Vector2d(u, v));
        }
    });
    return rays;
}

Rendering Renderer::render(int camera_index, const Eigen::Isometry3d& T_world_imu, double t_s) {
    const types::Camera& camera = camera_index == 0 ? rig_.cam0 : rig_.cam1;
    const Eigen::Isometry3d T_world_cam =
        T_world_imu * (camera_index == 0 ? rig_.T_imu_cam0 : rig_.T_imu_cam1);
    const double focal_px = camera::axial_magnification(camera) * camera.fx_px;
    Eye eye{.camera = camera_index,
            .rays = &rays_[static_cast<std::size_t>(camera_index)],
            .R_world_cam = T_world_cam.linear().cast<float>(),
            .center_world = T_world_cam.translation().cast<float>(),
            .pixel_size = static_cast<float>(1.0 / focal_px),
            .t_s = static_cast<float>(t_s)};
    for (std::size_t i = 0; i < kLamps_cam0.size(); ++i)
        eye.lamps_world[i] = (T_world_imu * rig_.T_imu_cam0 * kLamps_cam0[i]).cast<float>();
    for (const Fish& fish : options_.fish) {
        Fish::Shape shape = fish.at(t_s);
        const Eigen::Vector3d p_cam = T_world_cam.inverse() * shape.center_world.cast<double>();
        const auto pixel = camera::project(camera, p_cam);
        if (!pixel || p_cam.z() < 2.0 * shape.radius_m || p_cam.z() > 6.0) continue;
        const int reach =
            2 + static_cast<int>(1.5 * focal_px * shape.radius_m / (p_cam.z() - shape.radius_m));
        const cv::Rect box(static_cast<int>(pixel->x()) - reach,
                           static_cast<int>(pixel->y()) - reach,
                           2 * reach + 1,
                           2 * reach + 1);
        eye.fish.push_back({std::move(shape), box});
    }

    Rendering rendering = empty_rendering(camera);
    tbb::parallel_for(0, camera.height_px, [&](int row) { render_row(eye, row, rendering); });
    draw_snow(camera_index, T_world_imu, t_s, rendering);
    return rendering;
}

Rendering Renderer::render_water(int camera,
                                 const Eigen::Isometry3d& T_world_imu,
                                 double t_s) const {
    Rendering rendering = empty_rendering(camera == 0 ? rig_.cam0 : rig_.cam1);
    rendering.radiance.setTo(to_vec(options_.water.veil));
    draw_snow(camera, T_world_imu, t_s, rendering);
    return rendering;
}

void Renderer::draw_snow(int camera,
                         const Eigen::Isometry3d& T_world_imu,
                         double t_s,
                         Rendering& rendering) const {
    if (!options_.snow) return;
    options_.snow->draw(camera == 0 ? rig_.cam0 : rig_.cam1,
                        T_world_imu * (camera == 0 ? rig_.T_imu_cam0 : rig_.T_imu_cam1),
                        t_s,
                        options_.water,
                        rendering);
}

void Renderer::render_row(const Eye& eye, int row, Rendering& rendering) {
    const int width = rendering.radiance.cols;
    for (int u = 0; u < width; ++u) {
        const std::size_t pixel = static_cast<std::size_t>(row) * width + u;
        RayCaster::Rays4 rays = eye.rays->samples[pixel];
        for (RayCaster::Ray& ray : rays) ray = eye.in_world(ray);
        const auto hits = caster_.cast4(rays);
        mark_seen(eye, hits, rays);
        const bool fish_near = std::any_of(eye.fish.begin(), eye.fish.end(), [&](const auto& fish) {
            return fish.box.contains({u, row});
        });
        const auto point = fish_near ? std::nullopt : one_point(eye, hits, rays);
        Rgb albedo = Rgb::Zero();
        Rgb radiance = Rgb::Zero();
        if (point)
            radiance = look_at(eye, *point, albedo);
        else
            for (std::size_t i = 0; i < hits.size(); ++i) {
                const auto fish =
                    fish_near ? nearest_fish(eye, {u, row}, hits[i], rays[i]) : std::nullopt;
                if (fish) rendering.fish.at<std::uint8_t>(row, u) = 255;
                Rgb albedo_there = Rgb::Zero();
                radiance +=
                    0.25F * sample(eye, hits[i], rays[i], fish ? &*fish : nullptr, albedo_there);
                albedo += 0.25F * albedo_there;
            }
        rendering.radiance.at<cv::Vec3f>(row, u) = to_vec(radiance);
        rendering.albedo.at<cv::Vec3f>(row, u) = to_vec(albedo);
        if (!options_.exact_depth) {
            rendering.depth.at<float>(row, u) = hits[0].t;
            continue;
        }
        const auto [origin, direction] = eye.in_world(eye.rays->centers[pixel]);
        rendering.depth.at<float>(row, u) = caster_.cast(origin, direction).t;
    }
}

void Renderer::mark_seen(const Eye& eye, const RayHits4& hits, const RayCaster::Rays4& rays) {
    // Written only once, so that the cache line stays shared by all threads afterwards.
    const auto mark = [](std::atomic<bool>& flag) {
        if (!flag.load(std::memory_order_relaxed)) flag.store(true, std::memory_order_relaxed);
    };
    for (std::size_t i = 0; i < hits.size(); ++i) {
        if (!hits[i].valid()) continue;
        mark(seen_[hits[i].triangle]);
        if (eye.camera == 0 && hits[i].t * rays[i].direction.norm() < kReferenceRange_m)
            mark(in_reference_[hits[i].triangle]);
    }
}

std::optional<Fish::Hit> Renderer::nearest_fish(const Eye& eye,
                                                const cv::Point& pixel,
                                                const RayHit& hit,
                                                const RayCaster::Ray& ray) const {
    std::optional<Fish::Hit> nearest;
    for (const Eye::VisibleFish& candidate : eye.fish) {
        if (!candidate.box.contains(pixel)) continue;
        const auto fish = Fish::intersect(candidate.shape, ray.origin, ray.direction);
        if (fish && (!hit.valid() || fish->t < hit.t) && (!nearest || fish->t < nearest->t))
            nearest = fish;
    }
    return nearest;
}

std::optional<Renderer::Point> Renderer::one_point(const Eye& eye,
                                                   const RayHits4& hits,
                                                   const RayCaster::Rays4& rays) const {
    const auto object = [&](const RayHit& hit) { return scene_.triangle_object[hit.triangle]; };
    for (const RayHit& hit : hits)
        if (!hit.valid() || object(hit) != object(hits[0])) return std::nullopt;
    Point sum = point_at(hits[0], rays[0]);
    const Eigen::Vector3f normal = sum.normal_world;
    float nearest = sum.t;
    float farthest = sum.t;
    for (std::size_t i = 1; i < hits.size(); ++i) {
        const Point point = point_at(hits[i], rays[i]);
        if (point.normal_world.dot(normal) < kSmoothCosine) return std::nullopt;
        nearest = std::min(nearest, point.t);
        farthest = std::max(farthest, point.t);
        sum.p_world += point.p_world;
        sum.normal_world += point.normal_world;
        sum.t += point.t;
        sum.sky += point.sky;
        sum.sun += point.sun;
    }
    if (farthest - nearest > kSmoothSlope * eye.pixel_size * nearest) return std::nullopt;
    return Point{0.25F * sum.p_world,
                 sum.normal_world.normalized(),
                 sum.object,
                 0.25F * sum.t,
                 0.25F * sum.sky,
                 0.25F * sum.sun};
}

Rgb Renderer::sample(const Eye& eye,
                     const RayHit& hit,
                     const RayCaster::Ray& ray,
                     const Fish::Hit* fish,
                     Rgb& albedo) const {
    const Water& water = options_.water;
    Rgb radiance = water.is_water ? water.veil : Rgb(0.5F, 0.5F, 0.5F);
    if (hit.valid()) radiance = look_at(eye, point_at(hit, ray), albedo);
    if (!fish) return radiance;
    const Point point{
        ray.origin + fish->t * ray.direction, fish->normal_world, nullptr, fish->t, 1.0F, 1.0F};
    return water.look_through(shade(eye, point, fish->color, eye.pixel_size * fish->t),
                              fish->t * ray.direction.norm());
}

Rgb Renderer::look_at(const Eye& eye, const Point& point, Rgb& albedo) const {
    const Eigen::Vector3f ray = point.p_world - eye.center_world;
    const float range_m = ray.norm();
    const float cosine = std::abs(point.normal_world.dot(ray)) / range_m;
    const float footprint_m = eye.pixel_size * point.t / std::sqrt(std::max(0.12F, cosine));
    albedo = albedo_of(point, footprint_m);
    return options_.water.look_through(shade(eye, point, albedo, footprint_m), range_m);
}

Rgb Renderer::albedo_of(const Point& point, float footprint_m) const {
    const auto color = [&](float resolved_m) {
        return surface_color(*point.object, noise_, point.p_world, point.normal_world, resolved_m);
    };
    const float contrast = options_.texture_contrast;
    if (contrast == 1.0F || point.object->material == Material::Marker) return color(footprint_m);
    const Rgb flat = color(kNoPattern_m);
    return flat + contrast * (color(footprint_m) - flat);
}

Renderer::Point Renderer::point_at(const RayHit& hit, const RayCaster::Ray& ray) const {
    const auto& corners = scene_.triangles[hit.triangle];
    const float w = 1.0F - hit.u - hit.v;
    const auto blend = [&](const auto& value) {
        return w * value(corners[0]) + hit.u * value(corners[1]) + hit.v * value(corners[2]);
    };
    const Eigen::Vector3f normal = w * scene_.normals[corners[0]] +
                                   hit.u * scene_.normals[corners[1]] +
                                   hit.v * scene_.normals[corners[2]];
    return {ray.origin + hit.t * ray.direction,
            normal.normalized(),
            &scene_.objects[scene_.triangle_object[hit.triangle]],
            hit.t,
            blend([&](std::uint32_t vertex) { return light_.sky(vertex); }),
            blend([&](std::uint32_t vertex) { return light_.sun(vertex); })};
}

Rgb Renderer::shade(const Eye& eye, const Point& point, const Rgb& color, float footprint_m) const {
    const Water& water = options_.water;
    const Eigen::Vector3f& normal = point.normal_world;
    Rgb light = water.ambient * ((0.15F + 0.85F * point.sky) * (0.65F + 0.35F * normal.z()));
    const float facing = point.sun * std::max(0.0F, normal.dot(to_sun_));
    if (facing > 0.0F) {
        const float waves = options_.caustics
                                ? caustic(noise_, point.p_world, to_sun_, eye.t_s, footprint_m)
                                : 1.0F;
        light += water.sun * (facing * waves);
    }
    for (const Eigen::Vector3f& lamp : eye.lamps_world) {
        const Eigen::Vector3f to_lamp = lamp - point.p_world;
        const float range_m = std::max(0.3F, to_lamp.norm());
        const float cosine = normal.dot(to_lamp) / range_m;
        if (cosine <= 0.0F) continue;
        light += water.strobe * (-water.attenuation_per_m * range_m).exp() *
                 (cosine / (range_m * range_m));
    }
    return color * light;
}

std::vector<bool> Renderer::seen_triangles() const { return {seen_.begin(), seen_.end()}; }

std::vector<bool> Renderer::reference_triangles() const {
    return {in_reference_.begin(), in_reference_.end()};
}

}  // namespace divemesh::simulator
