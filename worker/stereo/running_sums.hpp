#pragma once

#include <cstdint>
#include <vector>

#include "worker/base/instructions.hpp"

namespace divemesh::stereo {

// Sums of several quantities over a square window that runs down an image, row by row. Integers, so
// that they are exact and cost the same at any window size.
class RunningSums {
public:
    using Row = std::vector<std::int32_t>;

    RunningSums(int num_terms, int width, int radius_px, base::Instructions instructions);

    // The terms of the next row, to be written before add_row(); they start as they were 2 radius +
    // 1 rows ago.
    Row& next(int term) { return entering_[static_cast<std::size_t>(term)]; }
    void add_row();
    // Whether a whole window has been seen; its centre is then `radius_px` above the last row.
    bool whole() const { return num_rows_ > 2 * radius_px_; }
    // Window sums by the column of the centre; zero where the window leaves the image.
    const std::vector<float>& sums(int term) const { return sums_[static_cast<std::size_t>(term)]; }

private:
    int radius_px_;
    base::Instructions instructions_;
    int num_rows_ = 0;
    std::vector<Row> entering_;
    std::vector<std::vector<Row>> rows_;  // the last 2 radius + 1, in turn
    std::vector<Row> columns_;            // their sums
    std::vector<std::vector<float>> sums_;
};

}  // namespace divemesh::stereo
