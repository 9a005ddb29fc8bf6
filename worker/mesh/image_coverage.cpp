#include "worker/mesh/image_coverage.hpp"

#include <algorithm>
#include <cstddef>

#include "worker/mesh/triangle_pixels.hpp"

namespace divemesh::mesh {
namespace {

constexpr int kWidth_px = 160;  // of the grid

// The left camera of a keyframe, with the pixels of the grid.
struct GridCamera {
    Eigen::Isometry3f T_cam_world;
    int columns = 0;
    int rows = 0;
    float focal_px = 0.0F;
    float cx_px = 0.0F;  // pixel centres at halves
    float cy_px = 0.0F;
};

GridCamera camera_of(const types::RectifiedRig& rig, const types::Keyframe& keyframe) {
    GridCamera camera;
    camera.T_cam_world = keyframe.T_world_cam.inverse().cast<float>();
    camera.columns = std::min(kWidth_px, rig.width_px);
    const double scale = static_cast<double>(camera.columns) / std::max(1, rig.width_px);
    camera.rows = std::max(1, static_cast<int>(scale * rig.height_px));
    camera.focal_px = static_cast<float>(scale * rig.focal_px);
    camera.cx_px = static_cast<float>(scale * (rig.cx_px + 0.5));
    camera.cy_px = static_cast<float>(scale * (rig.cy_px + 0.5));
    return camera;
}

// Returns the vertices in the image, with their depth as z; a depth of 0: behind the camera.
std::vector<Eigen::Vector3f> projected(const types::Mesh& mesh, const GridCamera& camera) {
    constexpr auto kMinDepth_m = static_cast<float>(types::RectifiedRig::kMinDepth_m);
    std::vector<Eigen::Vector3f> pixels;
    pixels.reserve(mesh.vertices.size());
    for (const Eigen::Vector3f& vertex : mesh.vertices) {
        const Eigen::Vector3f p = camera.T_cam_world * vertex;
        if (p.z() < kMinDepth_m) {
            pixels.emplace_back(0.0F, 0.0F, 0.0F);
            continue;
        }
        const float scale = camera.focal_px / p.z();
        pixels.emplace_back(scale * p.x() + camera.cx_px, scale * p.y() + camera.cy_px, p.z());
    }
    return pixels;
}

double covered_share(const types::Mesh& mesh, const GridCamera& camera) {
    const auto pixels = projected(mesh, camera);
    std::vector<std::uint8_t> covered(static_cast<std::size_t>(camera.columns) * camera.rows, 0);
    for (const auto& triangle : mesh.triangles) {
        const PixelTriangle corners = {
            pixels[triangle[0]], pixels[triangle[1]], pixels[triangle[2]]};
        if (corners[0].z() <= 0.0F || corners[1].z() <= 0.0F || corners[2].z() <= 0.0F) continue;
        for_each_pixel(corners,
                       camera.rows,
                       camera.columns,
                       [&](int row, int column, const Eigen::Vector3f&, float) {
                           covered[static_cast<std::size_t>(row) * camera.columns + column] = 1;
                       });
    }
    const auto num = std::count(covered.begin(), covered.end(), 1);
    return static_cast<double>(num) / static_cast<double>(covered.size());
}

}  // namespace

std::vector<ImageCoverage> image_coverage(const types::Mesh& mesh,
                                          const types::RectifiedRig& rig,
                                          const std::vector<types::Keyframe>& keyframes,
                                          int max_images) {
    const std::size_t num = std::min(keyframes.size(), static_cast<std::size_t>(max_images));
    std::vector<ImageCoverage> images;
    for (std::size_t i = 0; i < num; ++i) {
        const types::Keyframe& keyframe = keyframes[(2 * i + 1) * keyframes.size() / (2 * num)];
        images.push_back({keyframe.timestamp_ns, covered_share(mesh, camera_of(rig, keyframe))});
    }
    return images;
}

double mean_covered_share(const std::vector<ImageCoverage>& images) {
    double sum = 0.0;
    for (const ImageCoverage& image : images) sum += image.covered_share;
    return images.empty() ? 0.0 : sum / static_cast<double>(images.size());
}

}  // namespace divemesh::mesh
