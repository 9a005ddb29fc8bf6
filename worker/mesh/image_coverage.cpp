#include "worker/mesh/image_coverage.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "worker/fusion/voxel_size.hpp"
#include "worker/mesh/triangle_pixels.hpp"

namespace divemesh::mesh {
namespace {

constexpr int kWidth_px = 160;        // of the grid
constexpr std::size_t kChunk = 1024;  // consecutive triangles, which lie close to each other
constexpr double kMaxSigmas = 3.0;    // of a depth
constexpr double kMaxVoxels = 2.0;    // that fusion may move surface by

// A run of triangles with a sphere around it.
struct Chunk {
    std::size_t begin = 0;
    std::size_t end = 0;
    Eigen::Vector3f center_world;
    float radius_m = 0.0F;
};

std::vector<Chunk> chunks_of(const types::Mesh& mesh) {
    std::vector<Chunk> chunks;
    for (std::size_t begin = 0; begin < mesh.triangles.size(); begin += kChunk) {
        const std::size_t end = std::min(mesh.triangles.size(), begin + kChunk);
        Eigen::AlignedBox3f box;
        for (std::size_t i = begin; i < end; ++i)
            for (const std::uint32_t vertex : mesh.triangles[i]) box.extend(mesh.vertices[vertex]);
        chunks.push_back({begin, end, box.center(), 0.5F * box.diagonal().norm()});
    }
    return chunks;
}

// The left camera of a keyframe, with the pixels of the grid.
struct GridCamera {
    Eigen::Isometry3f T_cam_world;
    int columns = 0;
    int rows = 0;
    float focal_px = 0.0F;
    float cx_px = 0.0F;  // pixel centres at halves
    float cy_px = 0.0F;

    std::size_t num_pixels() const { return static_cast<std::size_t>(columns) * rows; }

    // Returns the pixel with the inverse depth as z, which is linear over a triangle; z is 0 for a
    // point that is not in front of the camera.
    Eigen::Vector3f project(const Eigen::Vector3f& p_world) const {
        constexpr auto kMinDepth_m = static_cast<float>(types::RectifiedRig::kMinDepth_m);
        const Eigen::Vector3f p = T_cam_world * p_world;
        if (p.z() < kMinDepth_m) return Eigen::Vector3f::Zero();
        const float inverse = 1.0F / p.z();
        const float scale = focal_px * inverse;
        return {scale * p.x() + cx_px, scale * p.y() + cy_px, inverse};
    }

    // Returns false only if the image shows nothing of the sphere.
    bool may_see(const Chunk& chunk) const {
        const Eigen::Vector3f p = T_cam_world * chunk.center_world;
        const auto is_inside = [&](float along, float principal_px, int size_px) {
            const float other_px = static_cast<float>(size_px) - principal_px;
            return (focal_px * along + principal_px * p.z()) >=
                       -chunk.radius_m * std::hypot(focal_px, principal_px) &&
                   (other_px * p.z() - focal_px * along) >=
                       -chunk.radius_m * std::hypot(focal_px, other_px);
        };
        return p.z() > -chunk.radius_m && is_inside(p.x(), cx_px, columns) &&
               is_inside(p.y(), cy_px, rows);
    }
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

// What a pixel of the grid must show.
struct Expected {
    float depth_m = 0.0F;  // 0: unknown, so any surface counts
    float tolerance_m = 0.0F;

    bool agrees(float inverse_depth) const {
        return depth_m <= 0.0F || std::abs(1.0F / inverse_depth - depth_m) <= tolerance_m;
    }
};

// Returns the depth at the centres of the grid's pixels.
std::vector<Expected> expected_depths(const types::RectifiedRig& rig,
                                      const types::DepthMap& depth,
                                      const GridCamera& camera,
                                      const CoverageSettings& settings) {
    std::vector<Expected> expected(camera.num_pixels());
    const cv::Mat& disparities = depth.disparity_px;
    for (int row = 0; row < camera.rows && !disparities.empty(); ++row)
        for (int column = 0; column < camera.columns; ++column) {
            const int v = (2 * row + 1) * disparities.rows / (2 * camera.rows);
            const int u = (2 * column + 1) * disparities.cols / (2 * camera.columns);
            const double disparity_px = static_cast<double>(disparities.at<float>(v, u));
            if (disparity_px <= 0.0) continue;
            const double depth_m = rig.depth_m(disparity_px);
            if (settings.max_depth_m > 0.0 && depth_m > settings.max_depth_m) continue;
            const double sigma_m = static_cast<double>(depth.sigma_disparity_px.at<float>(v, u)) /
                                   disparity_px * depth_m;
            const double voxel_m = std::clamp(fusion::choose_voxel_m(rig, depth_m),
                                              settings.finest_voxel_m,
                                              settings.coarsest_voxel_m);
            expected[static_cast<std::size_t>(row) * camera.columns + column] = {
                static_cast<float>(depth_m),
                static_cast<float>(kMaxSigmas * sigma_m + kMaxVoxels * voxel_m +
                                   settings.mesh_error_m)};
        }
    return expected;
}

enum class Pixel : std::uint8_t { Empty, OtherDepth, Covered };

// Returns what the surface does to each pixel of the grid; where several parts of it project there,
// the best of them counts.
std::vector<Pixel> covered_pixels(const types::Mesh& mesh,
                                  const std::vector<Chunk>& chunks,
                                  const GridCamera& camera,
                                  const std::vector<Expected>& expected) {
    std::vector<Pixel> covered(camera.num_pixels(), Pixel::Empty);
    for (const Chunk& chunk : chunks) {
        if (!camera.may_see(chunk)) continue;
        for (std::size_t i = chunk.begin; i < chunk.end; ++i) {
            const auto& [a, b, c] = mesh.triangles[i];
            const PixelTriangle corners = {camera.project(mesh.vertices[a]),
                                           camera.project(mesh.vertices[b]),
                                           camera.project(mesh.vertices[c])};
            if (corners[0].z() <= 0.0F || corners[1].z() <= 0.0F || corners[2].z() <= 0.0F)
                continue;
            for_each_pixel(corners,
                           camera.rows,
                           camera.columns,
                           [&](int row, int column, const Eigen::Vector3f&, float inverse_depth) {
                               const std::size_t at =
                                   static_cast<std::size_t>(row) * camera.columns + column;
                               if (covered[at] == Pixel::Covered) return;
                               covered[at] = expected[at].agrees(inverse_depth) ? Pixel::Covered
                                                                                : Pixel::OtherDepth;
                           });
        }
    }
    return covered;
}

ImageCoverage coverage_of(std::int64_t timestamp_ns,
                          const std::vector<Pixel>& covered,
                          const std::vector<Expected>& expected) {
    std::int64_t num_covered = 0;
    std::int64_t num_matched = 0;
    std::int64_t num_both = 0;
    for (std::size_t i = 0; i < covered.size(); ++i) {
        const bool is_matched = expected[i].depth_m > 0.0F;
        num_covered += covered[i] != Pixel::Empty ? 1 : 0;
        num_matched += is_matched ? 1 : 0;
        num_both += is_matched && covered[i] == Pixel::Covered ? 1 : 0;
    }
    const auto share = [&](std::int64_t num) {
        return static_cast<double>(num) / static_cast<double>(covered.size());
    };
    return {timestamp_ns, share(num_covered), share(num_matched), share(num_both)};
}

}  // namespace

std::vector<ImageCoverage> image_coverage(const types::Mesh& mesh,
                                          const types::RectifiedRig& rig,
                                          const std::vector<types::Keyframe>& keyframes,
                                          const DepthOfFrame& depth_of_frame,
                                          const CoverageSettings& settings) {
    const std::size_t num =
        std::min(keyframes.size(), static_cast<std::size_t>(settings.max_images));
    const std::vector<Chunk> chunks = chunks_of(mesh);
    std::vector<ImageCoverage> images;
    for (std::size_t i = 0; i < num; ++i) {
        const types::Keyframe& keyframe = keyframes[(2 * i + 1) * keyframes.size() / (2 * num)];
        const GridCamera camera = camera_of(rig, keyframe);
        const auto expected =
            expected_depths(rig, depth_of_frame(keyframe.frame_index), camera, settings);
        images.push_back(coverage_of(
            keyframe.timestamp_ns, covered_pixels(mesh, chunks, camera, expected), expected));
    }
    return images;
}

double mean_covered_share(const std::vector<ImageCoverage>& images) {
    double sum = 0.0;
    for (const ImageCoverage& image : images) sum += image.covered_share;
    return images.empty() ? 0.0 : sum / static_cast<double>(images.size());
}

std::optional<double> covered_share_of_matched(const std::vector<ImageCoverage>& images) {
    double covered = 0.0;
    double matched = 0.0;
    for (const ImageCoverage& image : images) {
        covered += image.covered_matched_share;
        matched += image.matched_share;
    }
    return matched > 0.0 ? std::optional(covered / matched) : std::nullopt;
}

}  // namespace divemesh::mesh
