#include "worker/compare/change_map.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>

#include "worker/base/parallel.hpp"
#include "worker/compare/change_scatter.hpp"
#include "worker/stats/distributions.hpp"

namespace divemesh::compare {
namespace {

constexpr float kNothing = std::numeric_limits<float>::quiet_NaN();
constexpr float kMinSigma_m = 5e-4F;  // no surface is known better, whatever its sigma
constexpr float kMinNormalZ = 0.25F;  // min z of normals; steeper surface is treated as this
constexpr double kMinBehind_m = 0.005;
constexpr double kBehindShare = 0.3;  // relative to the change

std::uint32_t nearest_corner(const types::Mesh& mesh,
                             const SurfaceRaster& raster,
                             int row,
                             int column) {
    const auto& corners =
        mesh.triangles[static_cast<std::size_t>(raster.triangle.at<int>(row, column))];
    const auto& w = raster.weights.at<cv::Vec2f>(row, column);
    const float first = 1.0F - w[0] - w[1];
    if (first >= w[0] && first >= w[1]) return corners[0];
    return w[0] >= w[1] ? corners[1] : corners[2];
}

// Returns the standard deviation of the height, m.
float height_sigma_m(const types::Mesh& mesh, std::uint32_t vertex) {
    const float along_normal = mesh.sigma_m.empty() ? 0.0F : mesh.sigma_m[vertex];
    return std::max(kMinSigma_m, along_normal) /
           std::max(kMinNormalZ, std::abs(mesh.normals[vertex].z()));
}

class Mapper {
public:
    Mapper(const Surveyed& a, const Surveyed& b, double reach_m, ChangeMap& map)
        : a_(a),
          b_(b),
          reach_m_(static_cast<float>(reach_m)),
          map_(map),
          raster_a_(rasterise(a.mesh, map.grid)),
          raster_b_(rasterise(b.mesh, map.grid)) {}

    void measure(int row, int column) const {
        auto& state = map_.state.at<std::uint8_t>(row, column);
        const bool seen_a = raster_a_.seen(row, column);
        const bool seen_b = raster_b_.seen(row, column);
        state = static_cast<std::uint8_t>(seen_a ? (seen_b ? CellState::Stable : CellState::OnlyA)
                                                 : (seen_b ? CellState::OnlyB : CellState::Unseen));
        if (!seen_a || !seen_b) return;
        const std::uint32_t vertex_a = nearest_corner(a_.mesh, raster_a_, row, column);
        const std::uint32_t vertex_b = nearest_corner(b_.mesh, raster_b_, row, column);
        const float change =
            raster_b_.height_m.at<float>(row, column) - raster_a_.height_m.at<float>(row, column);
        const float sigma =
            std::hypot(height_sigma_m(a_.mesh, vertex_a), height_sigma_m(b_.mesh, vertex_b));
        map_.change_m.at<float>(row, column) = change;
        map_.sigma_m.at<float>(row, column) = sigma;
        map_.later_surface.at<cv::Vec3f>(row, column) = surface_at(row, column, vertex_b);
        map_.registration_m.at<float>(row, column) =
            static_cast<float>(map_.registration_sigma(map_.change_by_motion(row, column)));
    }

    void scale(double scale_m) const { scale_by_scatter(map_, raster_a_, raster_b_, scale_m); }

    void decide(int row, int column) const {
        if (map_.at(row, column) != CellState::Stable) return;
        const float change = map_.change_m.at<float>(row, column);
        if (std::abs(change) <=
            static_cast<float>(stats::kNormal975) *
                (map_.sigma_m.at<float>(row, column) + map_.registration_m.at<float>(row, column)))
            return;
        const std::uint32_t vertex_a = nearest_corner(a_.mesh, raster_a_, row, column);
        const std::uint32_t vertex_b = nearest_corner(b_.mesh, raster_b_, row, column);
        if (!confirmed(a_.distances[vertex_a], b_.distances[vertex_b], change)) return;
        map_.state.at<std::uint8_t>(row, column) =
            static_cast<std::uint8_t>(change > 0.0F ? CellState::Grown : CellState::Lost);
    }

    // Checks cells that seem to have changed: the dive without the higher surface must have looked
    // through it. `of_b`: lost cells, into which b looks.
    void check(int row, int column, bool of_b, const evaluation::SurfaceIndex& index) const {
        const CellState state = map_.at(row, column);
        if (state != (of_b ? CellState::Lost : CellState::Grown)) return;
        const SurfaceRaster& higher = of_b ? raster_a_ : raster_b_;
        const Views& views = of_b ? *b_.views : *a_.views;
        const Eigen::Vector2d place = map_.grid.center(row, column);
        const auto height = static_cast<double>(higher.height_m.at<float>(row, column));
        const auto change = std::abs(static_cast<double>(map_.change_m.at<float>(row, column)));
        if (!is_free_space(views,
                           index,
                           {place.x(), place.y(), height},
                           std::max(kMinBehind_m, kBehindShare * change)))
            map_.state.at<std::uint8_t>(row, column) = static_cast<std::uint8_t>(CellState::Hidden);
    }

private:
    // A surface alone may have no distance: the normal at the flank of a new coral misses the other
    // dive's ground.
    bool confirmed(const M3c2Distance& of_a, const M3c2Distance& of_b, float change) const {
        const auto agrees = [&](const M3c2Distance& distance) {
            return !distance.known() ||
                   (distance.significant() && (distance.distance_m > 0.0F) == (change > 0.0F));
        };
        return agrees(of_a) && agrees(of_b) &&
               (of_a.known() || of_b.known() || std::abs(change) > reach_m_);
    }
    // Returns the slopes and the height of b, which is what the co-registration moves.
    cv::Vec3f surface_at(int row, int column, std::uint32_t vertex_b) const {
        const Eigen::Vector3f normal = b_.mesh.normals[vertex_b];
        const float up = std::copysign(std::max(kMinNormalZ, std::abs(normal.z())), normal.z());
        return {-normal.x() / up, -normal.y() / up, raster_b_.height_m.at<float>(row, column)};
    }

    const Surveyed& a_;
    const Surveyed& b_;
    float reach_m_;
    ChangeMap& map_;
    SurfaceRaster raster_a_;
    SurfaceRaster raster_b_;
};

}  // namespace

double ChangeMap::area_m2(CellState wanted) const {
    return cv::countNonZero(state == static_cast<int>(wanted)) * grid.cell_m * grid.cell_m;
}

Vector6d ChangeMap::change_by_motion(int row, int column) const {
    const auto& surface = later_surface.at<cv::Vec3f>(row, column);
    const Eigen::Vector2d place = grid.center(row, column);
    const Eigen::Vector3d lever_m =
        Eigen::Vector3d(place.x(), place.y(), static_cast<double>(surface[2])) - pivot;
    // A shift along x carries lower or higher ground to the cell.
    return motion_along(lever_m,
                        {-static_cast<double>(surface[0]), -static_cast<double>(surface[1]), 1.0});
}

ChangeMap map_changes(const Surveyed& a,
                      const Surveyed& b,
                      const CoRegistration& registration,
                      const MapOptions& options) {
    const RasterGrid& grid = options.grid;
    const auto of = [&](int type, double value) {
        return cv::Mat(grid.rows, grid.columns, type, cv::Scalar::all(value));
    };
    const auto nothing = static_cast<double>(kNothing);
    ChangeMap map{.grid = grid,
                  .state = of(CV_8U, 0.0),
                  .change_m = of(CV_32F, nothing),
                  .sigma_m = of(CV_32F, nothing),
                  .registration_m = of(CV_32F, nothing),
                  .later_surface = of(CV_32FC3, nothing),
                  .pivot = registration.pivot,
                  .registration_covariance = registration.covariance};
    const Mapper mapper(a, b, options.reach_m, map);
    const auto each_cell = [&](const auto& work) {
        base::for_each_index(
            options.num_threads, static_cast<std::size_t>(grid.rows), [&](std::size_t row) {
                for (int column = 0; column < grid.columns; ++column)
                    work(static_cast<int>(row), column);
            });
    };
    each_cell([&](int row, int column) { mapper.measure(row, column); });
    mapper.scale(options.scale_m);
    each_cell([&](int row, int column) { mapper.decide(row, column); });
    for (const bool of_b : {false, true}) {  // one index in memory at a time
        const Surveyed& looking = of_b ? b : a;
        if (!looking.views) continue;
        const evaluation::SurfaceIndex index(looking.mesh, true);
        each_cell([&](int row, int column) { mapper.check(row, column, of_b, index); });
    }
    return map;
}

}  // namespace divemesh::compare
