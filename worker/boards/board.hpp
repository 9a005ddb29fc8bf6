#pragma once

#include <Eigen/Core>
#include <string>
#include <string_view>

namespace divemesh::boards {

// Checkerboard: corners where four squares meet. AprilGrid: the corners of tags of family tag36h11
// with a border of two black cells, numbered from the lower left one to the right, then up, and
// with a black square at each corner, as Kalibr prints them.
enum class BoardKind { Checkerboard, AprilGrid };

// A calibration board. Frame `board`: x along a row, y along a column, z normal to the board;
// origin in the first corner.
struct Board {
    BoardKind kind = BoardKind::Checkerboard;
    int num_columns = 0;  // of inner corners or of tags
    int num_rows = 0;
    double column_step_m = 0.0;  // from a corner, or a tag, to the next in its row
    double row_step_m = 0.0;
    double tag_size_m = 0.0;  // edge of a tag; 0: a checkerboard

    int num_corner_columns() const;
    int num_corner_rows() const;
    // Corners are numbered along rows: row * num_corner_columns() + column.
    int num_corners() const { return num_corner_columns() * num_corner_rows(); }
    Eigen::Vector3d corner_m(int corner) const;
    Eigen::Vector3d center_m() const;
};

// Reads a target file of Kalibr: target_type checkerboard or aprilgrid. Throws Error{BadData},
// which names `file`, for another kind and for counts and sizes that no board has.
Board parse_board(std::string_view text, const std::string& file);

}  // namespace divemesh::boards
