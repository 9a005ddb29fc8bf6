#include "worker/color/surface_sightings.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/core.hpp>

#include "schemas/error.hpp"
#include "worker/color/thin_sightings.hpp"
#include "worker/types/triangle_area.hpp"

namespace divemesh::color {
namespace {

constexpr std::size_t kNumPoints = 6000;   // simulated dives have sigmas below 1 % with them
constexpr std::size_t kMaxSightings = 32;  // of a point: more tell little of its colour
constexpr std::size_t kSlice = 4;          // images that are decoded at the same time
constexpr int kWindow_px = 5;  // of the mean: a pose that is wrong by a pixel changes it little

struct SurfacePoint {
    Eigen::Vector3f p_world;
    Eigen::Vector3f normal_world;
};

// Returns the centres of triangles, at equal steps of area; empty for a surface without area.
std::vector<SurfacePoint> points_on(const types::Mesh& mesh) {
    double whole_m2 = 0.0;
    for (const auto& triangle : mesh.triangles) whole_m2 += types::triangle_area_m2(mesh, triangle);
    if (!(whole_m2 > 0.0) || !std::isfinite(whole_m2)) return {};
    const double step_m2 = whole_m2 / static_cast<double>(kNumPoints);
    std::vector<SurfacePoint> points;
    double passed_m2 = 0.5 * step_m2;
    for (const auto& triangle : mesh.triangles) {
        passed_m2 += types::triangle_area_m2(mesh, triangle);
        if (passed_m2 < step_m2) continue;
        passed_m2 = std::fmod(passed_m2, step_m2);
        const Eigen::Vector3f& a = mesh.vertices[triangle[0]];
        const Eigen::Vector3f& b = mesh.vertices[triangle[1]];
        const Eigen::Vector3f& c = mesh.vertices[triangle[2]];
        points.push_back({(a + b + c) / 3.0F, (b - a).cross(c - a).normalized()});
    }
    return points;
}

types::KeyframeImages read_or_empty(const ReadKeyframe& read, int frame_index) {
    try {
        types::KeyframeImages images = read(frame_index);
        return images.left_color.type() == CV_8UC3 ? images : types::KeyframeImages{};
    } catch (const Error& error) {
        if (error.code() == ErrorCode::Cancelled || error.code() == ErrorCode::OutOfMemory) throw;
    } catch (const cv::Exception&) {  // of a decoder
    }
    return {};
}

// Returns whether image and depth are of that size; there may be no depth.
bool has_size(const types::KeyframeImages& images, const cv::Size& size) {
    return images.left_color.size() == size &&
           (images.depth.disparity_px.empty() || images.depth.disparity_px.size() == size);
}

}  // namespace

std::size_t for_each_view(const SeenSurface& surface,
                          const std::vector<types::Keyframe>& keyframes,
                          const ReadKeyframe& read,
                          int num_threads,
                          const base::ProgressShare& progress,
                          const std::function<void(std::size_t, const KeyframeView&)>& visit) {
    const cv::Size size(surface.rig.width_px, surface.rig.height_px);
    std::size_t num_lost = 0;
    for (std::size_t begin = 0; begin < keyframes.size(); begin += kSlice) {
        progress.at(static_cast<double>(begin) / static_cast<double>(keyframes.size()));
        std::array<types::KeyframeImages, kSlice> images;
        const std::size_t num = std::min(kSlice, keyframes.size() - begin);
        base::for_each_index(num_threads, num, [&](std::size_t i) {
            images[i] = read_or_empty(read, keyframes[begin + i].frame_index);
        });
        for (std::size_t i = 0; i < num; ++i) {
            if (has_size(images[i], size))
                visit(begin + i,
                      KeyframeView(surface, keyframes[begin + i], images[i], num_threads));
            else
                ++num_lost;
        }
    }
    return num_lost;
}

Sightings surface_sightings(const SeenSurface& surface,
                            const std::vector<types::Keyframe>& keyframes,
                            const ReadKeyframe& read,
                            int num_threads,
                            const base::ProgressShare& progress) {
    const std::vector<SurfacePoint> points = points_on(surface.mesh);
    Sightings sightings{.num_points = points.size(), .num_keyframes = keyframes.size()};
    if (points.empty()) return sightings;
    std::vector<std::vector<Sighting>> of_points(points.size());
    const auto visit = [&](std::size_t keyframe, const KeyframeView& view) {
        base::for_each_index(num_threads, points.size(), [&](std::size_t i) {
            const auto seen = view.seen_at(points[i].p_world, points[i].normal_world, kWindow_px);
            if (!seen) return;
            of_points[i].push_back({static_cast<std::uint32_t>(i),
                                    static_cast<std::uint32_t>(keyframe),
                                    seen->range_m,
                                    seen->eccentricity,
                                    seen->cosine,
                                    seen->rgb});
            if (of_points[i].size() >= 2 * kMaxSightings)
                thin_sightings(of_points[i], kMaxSightings);
        });
    };
    sightings.num_lost_images =
        for_each_view(surface, keyframes, read, num_threads, progress, visit);
    for (std::vector<Sighting>& of_point : of_points) {
        thin_sightings(of_point, kMaxSightings);
        sightings.all.insert(sightings.all.end(), of_point.begin(), of_point.end());
    }
    return sightings;
}

}  // namespace divemesh::color
