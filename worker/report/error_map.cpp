#include "worker/report/error_map.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <iterator>
#include <limits>
#include <optional>

#include "worker/base/parallel.hpp"
#include "worker/evaluation/nearest_camera.hpp"
#include "worker/evaluation/surface_index.hpp"
#include "worker/mosaic/mosaic_grid.hpp"
#include "worker/mosaic/mosaic_renderer.hpp"
#include "worker/mosaic/thumbnail.hpp"
#include "worker/stats/quantile.hpp"

namespace divemesh::report {
namespace {

constexpr int kSide_px = 900;
constexpr std::array<types::Color, 9> kViridis = {{{68, 1, 84},
                                                   {71, 45, 123},
                                                   {59, 82, 139},
                                                   {44, 114, 142},
                                                   {33, 145, 140},
                                                   {39, 173, 129},
                                                   {93, 200, 99},
                                                   {170, 220, 50},
                                                   {253, 231, 37}}};

types::Color color_of(double share) {
    const double place = std::clamp(share, 0.0, 1.0) * (kViridis.size() - 1);
    const auto index = std::min(static_cast<std::size_t>(place), kViridis.size() - 2);
    const double rest = place - static_cast<double>(index);
    types::Color color{};
    for (std::size_t c = 0; c < 3; ++c)
        color[c] = static_cast<std::uint8_t>(
            std::lround((1.0 - rest) * kViridis[index][c] + rest * kViridis[index + 1][c]));
    return color;
}

double rounded_up(double value) {
    if (!(value > 0.0)) return 0.001;
    const double power = std::pow(10.0, std::floor(std::log10(value)));
    for (const double factor : {1.0, 2.0, 5.0})
        if (value <= factor * power * 1.000001) return factor * power;
    return 10.0 * power;
}

double max_side_m(const types::Mesh& mesh) {
    Eigen::AlignedBox3f box;
    for (const Eigen::Vector3f& vertex : mesh.vertices) box.extend(vertex);
    return box.isEmpty() ? 1.0 : static_cast<double>(box.sizes().head<2>().maxCoeff());
}

class DistanceToReference {
public:
    explicit DistanceToReference(const types::Mesh& reference) {
        if (reference.triangles.empty())
            points_.emplace(reference);
        else
            surface_.emplace(reference);
    }
    float distance_m(const Eigen::Vector3f& point) const {
        return points_ ? points_->distance_m(point) : surface_->distance_m(point);
    }

private:
    std::optional<evaluation::PointIndex> points_;
    std::optional<evaluation::SurfaceIndex> surface_;
};

// Returns the distance of each pixel that shows surface within range, m; NaN elsewhere.
cv::Mat distances_m(const cv::Mat& heights_m,
                    const types::RasterGrid& grid,
                    const types::Mesh& reference,
                    const evaluation::SurfaceErrorInput& input) {
    const DistanceToReference surface(reference);
    std::vector<Eigen::Vector3f> cameras;
    for (const Eigen::Vector3d& position : input.camera_positions_world)
        cameras.push_back(position.cast<float>());
    const evaluation::NearestCamera nearest_camera(std::move(cameras));
    const auto limit_m = input.camera_positions_world.empty()
                             ? std::numeric_limits<float>::infinity()
                             : static_cast<float>(input.max_range_m);
    cv::Mat distance_m(heights_m.size(), CV_32F, cv::Scalar(std::nanf("")));
    base::for_each_index(
        input.num_threads, static_cast<std::size_t>(distance_m.rows), [&](std::size_t index) {
            const int row = static_cast<int>(index);
            for (int column = 0; column < distance_m.cols; ++column) {
                const float height_m = heights_m.at<float>(row, column);
                if (std::isnan(height_m)) continue;
                const Eigen::Vector3d p_world(grid.corner_x_m + (column + 0.5) * grid.pixel_m,
                                              grid.corner_y_m - (row + 0.5) * grid.pixel_m,
                                              static_cast<double>(height_m));
                if (nearest_camera.distance_m(p_world.cast<float>()) > limit_m) continue;
                distance_m.at<float>(row, column) =
                    surface.distance_m((input.T_reference_world * p_world).cast<float>());
            }
        });
    return distance_m;
}

double scale_end_m(const cv::Mat& distance_m) {
    std::vector<float> known_m;
    for (int row = 0; row < distance_m.rows; ++row)
        std::copy_if(distance_m.ptr<float>(row),
                     distance_m.ptr<float>(row) + distance_m.cols,
                     std::back_inserter(known_m),
                     [](float distance) { return !std::isnan(distance); });
    if (known_m.empty()) return 0.0;
    return rounded_up(static_cast<double>(stats::lower_quantile(std::move(known_m), 0.9)));
}

}  // namespace

ErrorMap render_error_map(const types::Mesh& mesh_world,
                          const types::Mesh& reference,
                          const evaluation::SurfaceErrorInput& input) {
    const types::RasterGrid grid =
        mosaic::mosaic_grid(mesh_world, std::max(1e-6, max_side_m(mesh_world) / (kSide_px - 1)));
    mosaic::MosaicRows image = mosaic::MosaicRenderer(mesh_world, nullptr, grid, input.num_threads)
                                   .rows(0, grid.height_px);
    const cv::Mat distance_m = distances_m(image.height_m, grid, reference, input);
    ErrorMap map;
    map.end_m = scale_end_m(distance_m);
    for (int row = 0; row < distance_m.rows; ++row)
        for (int column = 0; column < distance_m.cols; ++column) {
            auto& pixel = image.color.at<cv::Vec4b>(row, column);
            if (pixel[3] == 0) continue;
            const float distance = distance_m.at<float>(row, column);
            const types::Color color = std::isnan(distance)
                                           ? types::Color{205, 205, 205}
                                           : color_of(static_cast<double>(distance) / map.end_m);
            pixel = {color[2], color[1], color[0], 255};
        }
    map.png = mosaic::thumbnail_png(image.color, kSide_px);
    return map;
}

std::vector<std::string> error_map_colors() {
    std::vector<std::string> colors;
    for (const types::Color& color : kViridis) {
        char text[8];
        std::snprintf(text, sizeof text, "#%02x%02x%02x", color[0], color[1], color[2]);
        colors.emplace_back(text);
    }
    return colors;
}

}  // namespace divemesh::report
