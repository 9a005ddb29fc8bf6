#include "tests/bench/color_truth.hpp"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "tests/bench/ciede2000.hpp"
#include "worker/base/parallel.hpp"
#include "worker/color/linear_light.hpp"
#include "worker/evaluation/trajectory_error.hpp"
#include "worker/io/mesh_reader.hpp"
#include "worker/io/mosaic_files.hpp"
#include "worker/io/raster_reader.hpp"
#include "worker/io/trajectory_file.hpp"
#include "worker/simulator/simulate.hpp"
#include "worker/simulator/surface_color.hpp"
#include "worker/stats/median.hpp"

namespace divemesh::bench {
namespace {

namespace fs = std::filesystem;

constexpr double kSide_m = 0.01;    // of the squares
constexpr double kAbove_m = 20.0;   // where rays from above begin
constexpr float kBeside_m = 0.05F;  // how far the true surface may be from a vertex
constexpr double kSamePlace_m = 0.02;
constexpr std::size_t kMaxVertices = 50'000;
constexpr double kDarkest = 1e-3;  // linear light, of which a ratio is taken

std::optional<AlbedoScene::Place> from_above(const AlbedoScene& scene,
                                             const Eigen::Isometry3d& T_scene_world,
                                             const Eigen::Vector2d& point) {
    const Eigen::Vector3d above(point.x(), point.y(), kAbove_m);
    return scene.first_hit((T_scene_world * above).cast<float>(),
                           (T_scene_world.linear() * -Eigen::Vector3d::UnitZ()).cast<float>(),
                           static_cast<float>(kSide_m),
                           1e6F);
}

std::optional<LinearRgb> mean_of(const cv::Mat& bgra) {
    const auto& linear = color::linear_levels();
    LinearRgb sum = {};
    for (int row = 0; row < bgra.rows; ++row)
        for (int column = 0; column < bgra.cols; ++column) {
            const auto& pixel = bgra.at<cv::Vec4b>(row, column);
            if (pixel[3] == 0) return std::nullopt;
            for (int c = 0; c < 3; ++c)
                sum[static_cast<std::size_t>(c)] += static_cast<double>(linear[pixel[2 - c]]);
        }
    for (double& channel : sum) channel /= static_cast<double>(bgra.total());
    return sum;
}

std::vector<ColorPair> without_missing(const std::vector<std::optional<ColorPair>>& found) {
    std::vector<ColorPair> pairs;
    for (const auto& pair : found)
        if (pair) pairs.push_back(*pair);
    return pairs;
}

// Visits all squares with a colour on several threads.
template <typename Visit>
std::vector<ColorPair> pairs_of(const MosaicSquares& mosaic, const Visit& visit) {
    std::vector<std::optional<ColorPair>> found(mosaic.colors.size());
    base::for_each_index(0, static_cast<std::size_t>(mosaic.rows), [&](std::size_t row) {
        for (int column = 0; column < mosaic.columns; ++column) {
            const auto& shown = mosaic.at(column, static_cast<int>(row));
            if (shown)
                found[row * static_cast<std::size_t>(mosaic.columns) +
                      static_cast<std::size_t>(column)] =
                    visit(*shown, mosaic.center(column, static_cast<int>(row)));
        }
    });
    return without_missing(found);
}

}  // namespace

AlbedoScene::AlbedoScene(const std::string& scene, std::uint64_t seed, double length_m)
    : scene_(simulator::make_scene(simulator::scene_kind_from_string(scene), seed, 1, length_m)),
      caster_(scene_.vertices, scene_.triangles),
      noise_(simulator::texture_noise(seed)) {}

std::optional<AlbedoScene::Place> AlbedoScene::first_hit(const Eigen::Vector3f& origin,
                                                         const Eigen::Vector3f& direction,
                                                         float pixel_m,
                                                         float max_m) const {
    const simulator::RayHit hit = caster_.cast(origin, direction);
    if (!hit.valid() || hit.t > max_m) return std::nullopt;
    const auto& corners = scene_.triangles[hit.triangle];
    const Eigen::Vector3f normal = (1.0F - hit.u - hit.v) * scene_.normals[corners[0]] +
                                   hit.u * scene_.normals[corners[1]] +
                                   hit.v * scene_.normals[corners[2]];
    const Eigen::Vector3f p = origin + hit.t * direction;
    const simulator::Rgb albedo =
        simulator::surface_color(scene_.objects[scene_.triangle_object[hit.triangle]],
                                 noise_,
                                 p,
                                 normal.normalized(),
                                 pixel_m);
    return Place{p,
                 {static_cast<double>(albedo[0]),
                  static_cast<double>(albedo[1]),
                  static_cast<double>(albedo[2])}};
}

Eigen::Isometry3d align_with_scene(const fs::path& model, const fs::path& dive) {
    const fs::path truth = dive / "mav0/state_groundtruth_estimate0/data.csv";
    return evaluation::trajectory_error(io::read_trajectory(model / "trajectory.tum").poses,
                                        io::read_trajectory(truth).poses)
        .T_reference_surface;
}

MosaicSquares MosaicSquares::of(const fs::path& model) {
    const fs::path description = model / "mosaic.json";
    MosaicSquares squares;
    squares.grid =
        io::mosaic_grid_of(nlohmann::json::parse(std::ifstream(description)), description);
    io::RasterReader reader(model / "mosaic.tif");
    const int pixels = std::max(1, static_cast<int>(std::lround(kSide_m / squares.grid.pixel_m)));
    squares.side_m = pixels * squares.grid.pixel_m;
    squares.columns = reader.size().width / pixels;
    squares.rows = reader.size().height / pixels;
    for (int row = 0; row < squares.rows; ++row) {
        const cv::Mat strip = reader.rows(row * pixels, pixels);
        for (int column = 0; column < squares.columns; ++column)
            squares.colors.push_back(
                mean_of(strip.colRange(column * pixels, (column + 1) * pixels)));
    }
    return squares;
}

Eigen::Vector2d MosaicSquares::center(int column, int row) const {
    return {grid.corner_x_m + side_m * (column + 0.5), grid.corner_y_m - side_m * (row + 0.5)};
}

std::optional<LinearRgb> MosaicSquares::at(const Eigen::Vector2d& point) const {
    const double column = std::floor((point.x() - grid.corner_x_m) / side_m);
    const double row = std::floor((grid.corner_y_m - point.y()) / side_m);
    if (column < 0.0 || row < 0.0 || column >= columns || row >= rows) return std::nullopt;
    return at(static_cast<int>(column), static_cast<int>(row));
}

std::vector<ColorPair> mosaic_pairs(const MosaicSquares& mosaic,
                                    const AlbedoScene& scene,
                                    const Eigen::Isometry3d& T_scene_world) {
    return pairs_of(
        mosaic,
        [&](const LinearRgb& shown, const Eigen::Vector2d& point) -> std::optional<ColorPair> {
            const auto place = from_above(scene, T_scene_world, point);
            if (!place) return std::nullopt;
            return ColorPair{shown, place->albedo};
        });
}

std::vector<ColorPair> vertex_pairs(const fs::path& model,
                                    const AlbedoScene& scene,
                                    const Eigen::Isometry3d& T_scene_world) {
    const types::Mesh mesh = io::read_mesh(model / "mesh.ply");
    const auto& linear = color::linear_levels();
    const std::size_t step = 1 + mesh.vertices.size() / kMaxVertices;
    std::vector<ColorPair> pairs;
    for (std::size_t i = 0; i < mesh.vertices.size() && i < mesh.normals.size(); i += step) {
        const Eigen::Vector3f normal = T_scene_world.linear().cast<float>() * mesh.normals[i];
        const Eigen::Vector3f p = T_scene_world.cast<float>() * mesh.vertices[i];
        const auto place = scene.first_hit(
            p + kBeside_m * normal, -normal, static_cast<float>(kSide_m), 2.0F * kBeside_m);
        if (!place) continue;
        const types::Color& color = mesh.colors[i];
        pairs.push_back({{static_cast<double>(linear[color[0]]),
                          static_cast<double>(linear[color[1]]),
                          static_cast<double>(linear[color[2]])},
                         place->albedo});
    }
    return pairs;
}

std::vector<ColorPair> common_pairs(const MosaicSquares& one,
                                    const Eigen::Isometry3d& T_scene_one,
                                    const MosaicSquares& other,
                                    const Eigen::Isometry3d& T_scene_other,
                                    const AlbedoScene& scene) {
    const Eigen::Isometry3d T_other_scene = T_scene_other.inverse();
    return pairs_of(
        one, [&](const LinearRgb& shown, const Eigen::Vector2d& point) -> std::optional<ColorPair> {
            const auto place = from_above(scene, T_scene_one, point);
            if (!place) return std::nullopt;
            const Eigen::Vector3d p_other = T_other_scene * place->p.cast<double>();
            const auto there = from_above(scene, T_scene_other, p_other.head<2>());
            const auto color = other.at(p_other.head<2>());
            if (!there || !color ||
                static_cast<double>((there->p - place->p).norm()) > kSamePlace_m)
                return std::nullopt;
            return ColorPair{*color, shown};
        });
}

double median_error(const std::vector<ColorPair>& pairs, bool with_gains) {
    LinearRgb gains = {1.0, 1.0, 1.0};
    for (std::size_t c = 0; with_gains && c < 3; ++c) {
        std::vector<double> ratios;
        for (const ColorPair& pair : pairs)
            ratios.push_back(pair.truth[c] / std::max(kDarkest, pair.shown[c]));
        gains[c] = stats::median(std::move(ratios));
    }
    std::vector<double> errors;
    for (const ColorPair& pair : pairs) {
        const LinearRgb shown = {
            gains[0] * pair.shown[0], gains[1] * pair.shown[1], gains[2] * pair.shown[2]};
        errors.push_back(ciede2000(lab_of(shown), lab_of(pair.truth)));
    }
    return stats::median(std::move(errors));
}

}  // namespace divemesh::bench
