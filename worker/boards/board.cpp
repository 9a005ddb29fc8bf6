#include "worker/boards/board.hpp"

namespace divemesh::boards {

int Board::num_corner_columns() const {
    return kind == BoardKind::AprilGrid ? 2 * num_columns : num_columns;
}

int Board::num_corner_rows() const {
    return kind == BoardKind::AprilGrid ? 2 * num_rows : num_rows;
}

Eigen::Vector3d Board::corner_m(int corner) const {
    const int column = corner % num_corner_columns();
    const int row = corner / num_corner_columns();
    if (kind == BoardKind::Checkerboard) return {column * column_step_m, row * row_step_m, 0.0};
    return {(column / 2) * column_step_m + (column % 2) * tag_size_m,
            (row / 2) * row_step_m + (row % 2) * tag_size_m,
            0.0};
}

Eigen::Vector3d Board::center_m() const { return 0.5 * corner_m(num_corners() - 1); }

}  // namespace divemesh::boards
