#include "worker/mesh/image_coverage.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "worker/fusion/voxel_size.hpp"
#include "worker/mesh/image_camera.hpp"
#include "worker/mesh/triangle_pixels.hpp"
#include "worker/mesh/triangle_runs.hpp"

namespace divemesh::mesh {
namespace {

constexpr int kWidth_px = 160;      // of the grid
constexpr double kMaxSigmas = 3.0;  // of a depth
constexpr double kMaxVoxels = 2.0;  // that fusion may move surface by

ImageCamera camera_of(const types::RectifiedRig& rig, const types::Keyframe& keyframe) {
    const int columns = std::min(kWidth_px, rig.width_px);
    const double scale = static_cast<double>(columns) / std::max(1, rig.width_px);
    const int rows = std::max(1, static_cast<int>(scale * rig.height_px));
    return {rig, keyframe.T_world_cam, columns, rows};
}

std::size_t num_pixels(const ImageCamera& camera) {
    return static_cast<std::size_t>(camera.columns) * camera.rows;
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
                                      const ImageCamera& camera,
                                      const CoverageSettings& settings) {
    std::vector<Expected> expected(num_pixels(camera));
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
                                  const std::vector<TriangleRun>& runs,
                                  const ImageCamera& camera,
                                  const std::vector<Expected>& expected) {
    std::vector<Pixel> covered(num_pixels(camera), Pixel::Empty);
    for (const TriangleRun& run : runs) {
        if (!camera.may_see(run)) continue;
        for (std::size_t i = run.begin; i < run.end; ++i) {
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
    const std::vector<TriangleRun> runs = triangle_runs(mesh);
    std::vector<ImageCoverage> images;
    for (std::size_t i = 0; i < num; ++i) {
        const types::Keyframe& keyframe = keyframes[(2 * i + 1) * keyframes.size() / (2 * num)];
        const ImageCamera camera = camera_of(rig, keyframe);
        const auto expected =
            expected_depths(rig, depth_of_frame(keyframe.frame_index), camera, settings);
        images.push_back(coverage_of(
            keyframe.timestamp_ns, covered_pixels(mesh, runs, camera, expected), expected));
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
