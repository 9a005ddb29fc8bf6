#include "worker/compare/surface_raster.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace divemesh::worker {
namespace {

constexpr float kNothing = std::numeric_limits<float>::quiet_NaN();

// Cell centres within the triangle, the higher surface wins; of equals the one drawn first.
void draw(const std::array<Eigen::Vector3f, 3>& corners, int index, SurfaceRaster& raster) {
    const auto& [a, b, c] = corners;
    const float area = (b.x() - a.x()) * (c.y() - a.y()) - (b.y() - a.y()) * (c.x() - a.x());
    if (area == 0.0F) return;
    const auto first = [](float low) {
        return std::max(0, static_cast<int>(std::ceil(low - 0.5F)));
    };
    const auto last = [](float high, int count) {
        return std::min(count - 1, static_cast<int>(std::floor(high - 0.5F)));
    };
    const int last_row = last(std::max({a.y(), b.y(), c.y()}), raster.triangle.rows);
    const int last_column = last(std::max({a.x(), b.x(), c.x()}), raster.triangle.cols);
    for (int row = first(std::min({a.y(), b.y(), c.y()})); row <= last_row; ++row)
        for (int column = first(std::min({a.x(), b.x(), c.x()})); column <= last_column; ++column) {
            const float x = static_cast<float>(column) + 0.5F;
            const float y = static_cast<float>(row) + 0.5F;
            const float v = ((x - a.x()) * (c.y() - a.y()) - (y - a.y()) * (c.x() - a.x())) / area;
            const float w = ((b.x() - a.x()) * (y - a.y()) - (b.y() - a.y()) * (x - a.x())) / area;
            if (v < 0.0F || w < 0.0F || v + w > 1.0F) continue;
            const float height = a.z() + v * (b.z() - a.z()) + w * (c.z() - a.z());
            auto& highest = raster.height_m.at<float>(row, column);
            if (height <= highest) continue;  // false where there was nothing
            highest = height;
            raster.triangle.at<int>(row, column) = index;
            raster.weights.at<cv::Vec2f>(row, column) = {v, w};
        }
}

}  // namespace

RasterGrid grid_over(const Mesh& a, const Mesh& b, double cell_m, std::int64_t max_cells) {
    Eigen::Vector2d low = Eigen::Vector2d::Constant(std::numeric_limits<double>::max());
    Eigen::Vector2d high = -low;
    for (const Mesh* mesh : {&a, &b})
        for (const Eigen::Vector3f& p : mesh->vertices) {
            low = low.cwiseMin(p.head<2>().cast<double>());
            high = high.cwiseMax(p.head<2>().cast<double>());
        }
    RasterGrid grid;
    if (!(low.x() <= high.x())) return grid;
    const Eigen::Vector2d size = high - low;
    grid.cell_m = std::max({cell_m,
                            std::sqrt(size.prod() / static_cast<double>(max_cells)),
                            size.maxCoeff() / 30000.0});
    // Corners on multiples of the cell, so that the cells do not hang on the last vertex.
    const double west = std::floor(low.x() / grid.cell_m);
    const double north = std::ceil(high.y() / grid.cell_m);
    grid.corner_m = grid.cell_m * Eigen::Vector2d(west, north);
    grid.columns = static_cast<int>(std::floor(high.x() / grid.cell_m) - west) + 1;
    grid.rows = static_cast<int>(north - std::floor(low.y() / grid.cell_m)) + 1;
    return grid;
}

SurfaceRaster rasterise(const Mesh& mesh, const RasterGrid& grid) {
    SurfaceRaster raster{cv::Mat(grid.rows, grid.columns, CV_32F, cv::Scalar::all(kNothing)),
                         cv::Mat(grid.rows, grid.columns, CV_32S, cv::Scalar::all(-1)),
                         cv::Mat(grid.rows, grid.columns, CV_32FC2, cv::Scalar::all(0))};
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
        std::array<Eigen::Vector3f, 3> corners;
        for (std::size_t k = 0; k < 3; ++k) {
            const Eigen::Vector3d p = mesh.vertices[mesh.triangles[i][k]].cast<double>();
            corners[k] = Eigen::Vector3d((p.x() - grid.corner_m.x()) / grid.cell_m,
                                         (grid.corner_m.y() - p.y()) / grid.cell_m,
                                         p.z())
                             .cast<float>();
        }
        draw(corners, static_cast<int>(i), raster);
    }
    return raster;
}

double mean_edge_m(const Mesh& mesh) {
    double sum = 0.0;
    for (const auto& triangle : mesh.triangles)
        sum +=
            static_cast<double>((mesh.vertices[triangle[1]] - mesh.vertices[triangle[0]]).norm());
    return mesh.triangles.empty() ? 0.0 : sum / static_cast<double>(mesh.triangles.size());
}

}  // namespace divemesh::worker
