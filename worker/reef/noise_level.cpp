#include "worker/reef/noise_level.hpp"

#include <algorithm>
#include <cmath>

#include "worker/stats/distributions.hpp"
#include "worker/stats/quantile.hpp"

namespace divemesh::reef {
namespace {

constexpr std::size_t kMinDifferences = 100;

HeightGrid sigmas_at(const SurfacePatch& patch, const GridShape& shape) {
    std::vector<Eigen::Vector3d> vertices = patch.vertices;
    for (std::size_t i = 0; i < vertices.size(); ++i) vertices[i].z() = patch.sigma_local_m[i];
    return sample_heights(vertices, patch.triangles, shape);
}

}  // namespace

void NoiseLevel::add(const SurfacePatch& patch, const GridShape& shape) {
    const HeightGrid heights = sample_heights(patch.vertices, patch.triangles, shape);
    const HeightGrid sigmas = sigmas_at(patch, shape);
    const int steps = std::max(1, static_cast<int>(std::lround(lag_m_ / shape.spacing_m)));
    add_along(heights, sigmas, steps, 0);
    add_along(heights, sigmas, 0, steps);
}

void NoiseLevel::add_along(const HeightGrid& heights,
                           const HeightGrid& sigmas,
                           int columns,
                           int rows) {
    const double of_one_sigma = std::sqrt(6.0 - 8.0 * std::exp(-4.0) + 2.0 * std::exp(-16.0));
    const GridShape& shape = heights.shape;
    for (int row = rows; row + rows < shape.num_rows; ++row)
        for (int column = columns; column + columns < shape.num_columns; ++column) {
            const double sigma = sigmas.at(column, row);
            const double second = heights.at(column - columns, row - rows) -
                                  2.0 * heights.at(column, row) +
                                  heights.at(column + columns, row + rows);
            if (sigma > 0.0 && std::isfinite(second))
                sizes_.push_back(std::abs(second) / (of_one_sigma * sigma));
        }
}

double NoiseLevel::share() const {
    static const double kQuartileOfNormal = stats::normal_quantile(0.625);  // lower, of |N(0, 1)|
    if (sizes_.size() < kMinDifferences) return 1.0;
    return std::min(1.0, stats::upper_quantile(sizes_, 0.25) / kQuartileOfNormal);
}

}  // namespace divemesh::reef
