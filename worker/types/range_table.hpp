#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <vector>

namespace divemesh::types {

// By how much a rectified pair behind ports shows points elsewhere than an ideal pair: ideal minus
// measured (u, v, disparity), px, as a function of the measured values. Nodes lie evenly over the
// left image and over the square root of the disparity, of which the shift is a smooth function.
struct RangeTable {
    int num_columns = 0;
    int num_rows = 0;
    int num_layers = 0;
    double column_px = 0.0;                  // between nodes
    double row_px = 0.0;                     // between nodes
    double layer_root_px = 0.0;              // between nodes, of the square root
    std::vector<Eigen::Vector3f> shifts_px;  // by layer, row, column

    Eigen::Vector3f& node(int layer, int row, int column) {
        return shifts_px[index(layer, row, column)];
    }

    // Returns the shift, interpolated; that of the nearest place in the table for one beyond it.
    Eigen::Vector3d shift_px(const Eigen::Vector3d& measured_px) const {
        const Cell column(measured_px.x() / column_px, num_columns);
        const Cell row(measured_px.y() / row_px, num_rows);
        const Cell layer(std::sqrt(std::max(0.0, measured_px.z())) / layer_root_px, num_layers);
        Eigen::Vector3f sum = Eigen::Vector3f::Zero();
        for (int l = 0; l < 2; ++l)
            for (int r = 0; r < 2; ++r)
                for (int c = 0; c < 2; ++c)
                    sum += static_cast<float>(layer.weight(l) * row.weight(r) * column.weight(c)) *
                           shifts_px[index(layer.first + l, row.first + r, column.first + c)];
        return sum.cast<double>();
    }

private:
    // Two neighbouring nodes and a place between them.
    struct Cell {
        Cell(double at, int num_nodes)
            : first(std::clamp(static_cast<int>(at), 0, num_nodes - 2)),
              share(std::clamp(at - first, 0.0, 1.0)) {}
        double weight(int node) const { return node == 0 ? 1.0 - share : share; }

        int first;
        double share;
    };

    std::size_t index(int layer, int row, int column) const {
        return (static_cast<std::size_t>(layer) * num_rows + row) * num_columns + column;
    }
};

}  // namespace divemesh::types
