#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>

#include "worker/types/mesh.hpp"
#include "worker/types/raster_grid.hpp"

namespace divemesh::mosaic {

// The columns of a row [first, last]; empty if last < first.
struct ColumnSpan {
    int first = 0;
    int last = -1;
};

// A triangle of a mesh as a mosaic sees it: the weights of its corners as linear functions of
// column and row (pixel centres at halves).
class FlatTriangle {
public:
    // Returns nullopt for a triangle that has no area from above.
    static std::optional<FlatTriangle> of(const types::Mesh& mesh,
                                          std::size_t triangle,
                                          const types::RasterGrid& grid) {
        FlatTriangle flat;
        for (std::size_t i = 0; i < 3; ++i) {
            const Eigen::Vector3d corner =
                mesh.vertices[mesh.triangles[triangle][i]].cast<double>();
            const auto column = static_cast<Eigen::Index>(i);
            flat.corners_.col(column) =
                Eigen::Vector2d((corner.x() - grid.corner_x_m), (grid.corner_y_m - corner.y())) /
                grid.pixel_m;
            flat.heights_m_[column] = corner.z();
        }
        const Eigen::Vector2d ab = flat.corners_.col(1) - flat.corners_.col(0);
        const Eigen::Vector2d ac = flat.corners_.col(2) - flat.corners_.col(0);
        const double area = ab.x() * ac.y() - ab.y() * ac.x();
        if (!(std::abs(area) > kMinArea_px2)) return std::nullopt;
        flat.along_row_ = Eigen::Vector3d(ab.y() - ac.y(), ac.y(), -ab.y()) / area;
        flat.along_column_ = Eigen::Vector3d(ac.x() - ab.x(), -ac.x(), ab.x()) / area;
        return flat;
    }

    double top_px() const { return corners_.row(1).minCoeff(); }
    double bottom_px() const { return corners_.row(1).maxCoeff(); }
    const Eigen::Vector3d& along_row() const { return along_row_; }
    const Eigen::Vector3d& along_column() const { return along_column_; }

    Eigen::Vector3d weights(int row, int column) const {
        return Eigen::Vector3d::UnitX() + (column + 0.5 - corners_(0, 0)) * along_row_ +
               (row + 0.5 - corners_(1, 0)) * along_column_;
    }

    double height_m(const Eigen::Vector3d& weights) const { return weights.dot(heights_m_); }

    // Returns the columns whose centres lie in the triangle, or on its edge, which belongs to both
    // neighbours: no pixel between them stays empty.
    ColumnSpan span(int row, int num_columns) const {
        const Eigen::Vector3d at_start = weights(row, 0);
        double first = std::ceil(corners_.row(0).minCoeff() - 0.5 - kEdge);
        double last = std::floor(corners_.row(0).maxCoeff() - 0.5 + kEdge);
        for (Eigen::Index i = 0; i < 3; ++i) {
            const double inside = at_start[i] + kEdge;
            const double step = along_row_[i];
            if (step > 0.0) first = std::max(first, std::ceil(-inside / step));
            if (step < 0.0) last = std::min(last, std::floor(inside / -step));
            if (step == 0.0 && inside < 0.0) return {};
        }
        first = std::max(first, 0.0);
        last = std::min(last, num_columns - 1.0);
        if (first > last) return {};
        return {static_cast<int>(first), static_cast<int>(last)};
    }

private:
    static constexpr double kMinArea_px2 =
        1e-9;                              // of twice the area; below it weights mean nothing
    static constexpr double kEdge = 1e-6;  // of a weight: wider than rounding

    Eigen::Matrix<double, 2, 3> corners_;  // px
    Eigen::Vector3d heights_m_;
    Eigen::Vector3d along_row_;
    Eigen::Vector3d along_column_;
};

}  // namespace divemesh::mosaic
