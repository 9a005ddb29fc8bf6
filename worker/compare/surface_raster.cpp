#include "worker/compare/surface_raster.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "worker/mesh/triangle_pixels.hpp"

namespace divemesh::compare {
namespace {

constexpr float kNothing = std::numeric_limits<float>::quiet_NaN();

// Draws a triangle. The higher surface wins; among equals the one drawn first.
void draw(const mesh::PixelTriangle& corners, int index, SurfaceRaster& raster) {
    const auto set = [&](int row, int column, const Eigen::Vector3f& weights, float height) {
        auto& highest = raster.height_m.at<float>(row, column);
        if (height <= highest) return;  // false without a surface
        highest = height;
        raster.triangle.at<int>(row, column) = index;
        raster.weights.at<cv::Vec2f>(row, column) = {weights[1], weights[2]};
    };
    mesh::for_each_pixel(corners, raster.triangle.rows, raster.triangle.cols, set);
}

}  // namespace

cv::Mat cells_with_value(const cv::Mat& values) {
    cv::Mat mask;
    cv::compare(values, values, mask, cv::CMP_EQ);
    return mask;
}

cv::Mat disc(double radius_cells) {
    const int r = std::max(1, static_cast<int>(std::lround(radius_cells)));
    return cv::getStructuringElement(cv::MORPH_ELLIPSE, {2 * r + 1, 2 * r + 1});
}

RasterGrid grid_over(const types::Mesh& a,
                     const types::Mesh& b,
                     double cell_m,
                     std::int64_t max_cells) {
    Eigen::Vector2d low = Eigen::Vector2d::Constant(std::numeric_limits<double>::max());
    Eigen::Vector2d high = -low;
    for (const types::Mesh* mesh : {&a, &b})
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
    // Corners on multiples of the cell, so that the cells do not depend on the last vertex.
    const double west = std::floor(low.x() / grid.cell_m);
    const double north = std::ceil(high.y() / grid.cell_m);
    grid.corner_m = grid.cell_m * Eigen::Vector2d(west, north);
    grid.columns = static_cast<int>(std::floor(high.x() / grid.cell_m) - west) + 1;
    grid.rows = static_cast<int>(north - std::floor(low.y() / grid.cell_m)) + 1;
    return grid;
}

SurfaceRaster rasterise(const types::Mesh& mesh, const RasterGrid& grid) {
    SurfaceRaster raster{cv::Mat(grid.rows, grid.columns, CV_32F, cv::Scalar::all(kNothing)),
                         cv::Mat(grid.rows, grid.columns, CV_32S, cv::Scalar::all(-1)),
                         cv::Mat(grid.rows, grid.columns, CV_32FC2, cv::Scalar::all(0))};
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
        mesh::PixelTriangle corners;
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

}  // namespace divemesh::compare
