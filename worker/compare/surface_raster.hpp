#pragma once

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

#include "worker/types/mesh.hpp"

namespace divemesh::compare {

// Square cells of the horizontal plane. Row 0 is north (largest y), column 0 west; the outer corner
// of cell (0, 0) is at `corner_m`.
struct RasterGrid {
    double cell_m = 0.01;
    Eigen::Vector2d corner_m = Eigen::Vector2d::Zero();  // x of the west, y of the north side
    int rows = 1;
    int columns = 1;

    Eigen::Vector2d center(int row, int column) const {
        return corner_m + cell_m * Eigen::Vector2d(column + 0.5, -(row + 0.5));
    }
};

// Returns a mask (CV_8U) of the cells whose value (CV_32F) is not NaN.
cv::Mat cells_with_value(const cv::Mat& values);

// Returns a disc of cells to dilate or erode a mask with; its radius is rounded, to 1 cell at
// least.
cv::Mat disc(double radius_cells);

// The highest surface of a mesh over each cell's centre.
struct SurfaceRaster {
    cv::Mat height_m;  // CV_32F, z; NaN without a surface
    cv::Mat triangle;  // CV_32S; -1 without a surface
    cv::Mat weights;   // CV_32FC2: of the triangle's second and third corner

    bool seen(int row, int column) const { return triangle.at<int>(row, column) >= 0; }
    // Interpolates a value per vertex; the cell must be seen.
    template <typename Value>
    Value interpolate(const types::Mesh& mesh,
                      const std::vector<Value>& values,
                      int row,
                      int column) const {
        const auto& corners =
            mesh.triangles[static_cast<std::size_t>(triangle.at<int>(row, column))];
        const auto& weight = weights.at<cv::Vec2f>(row, column);
        return (1.0F - weight[0] - weight[1]) * values[corners[0]] +
               weight[0] * values[corners[1]] + weight[1] * values[corners[2]];
    }
};

// Returns a grid over the bounds of both meshes, with coarser cells if it would have more than
// `max_cells`.
RasterGrid grid_over(const types::Mesh& a,
                     const types::Mesh& b,
                     double cell_m,
                     std::int64_t max_cells);

// Returns the highest surface of a mesh at the centres of the grid's cells.
SurfaceRaster rasterise(const types::Mesh& mesh, const RasterGrid& grid);

}  // namespace divemesh::compare
