#pragma once

#include <cstdint>
#include <vector>

#include "worker/base/instructions.hpp"

namespace divemesh::stereo {

// Running sums of several quantities over a square window that moves down an image row by row. They
// are integers, therefore exact, and cost the same at any window size.
class RunningSums {
public:
    using Row = std::vector<std::int32_t>;

    RunningSums(int num_terms, int width, int radius_px, base::Instructions instructions);

    // Returns the buffer for a term of the next row, to be filled before add_row(). It contains the
    // values of 2 radius + 1 rows ago.
    Row& next(int term) { return entering_[static_cast<std::size_t>(term)]; }
    void add_row();
    // Returns true after a whole window of rows; its centre is `radius_px` above the last row.
    bool whole() const { return num_rows_ > 2 * radius_px_; }
    // Returns the window sums by the column of the centre; 0 where the window leaves the image.
    const std::vector<float>& sums(int term) const { return sums_[static_cast<std::size_t>(term)]; }

private:
    int radius_px_;
    base::Instructions instructions_;
    int num_rows_ = 0;
    std::vector<Row> entering_;
    std::vector<std::vector<Row>> rows_;  // the last 2 radius + 1, cyclic
    std::vector<Row> columns_;            // column sums of rows_
    std::vector<std::vector<float>> sums_;
};

}  // namespace divemesh::stereo
