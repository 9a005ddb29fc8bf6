#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace divemesh::dive {

// Undoes the Paeth filter (PNG specification 9.4) of rows of bytes, one byte a pixel.
class PaethRows {
public:
    static constexpr int kNumRows = 8;
    static constexpr int kMaxWidth = 1 << 16;  // of rows that are undone together

    explicit PaethRows(int width) : width_(width) {}

    // One row. `above` is the row over it, without filter; black over the first.
    void undo(const std::uint8_t* filtered, const std::uint8_t* above, std::uint8_t* row) const;

    // Eight rows at once, of at most kMaxWidth, which takes a third of the time: each is a pixel
    // behind the one above, so all eight pixels of a step are independent. The rows of `filtered`
    // are `step_bytes` apart, those of the image `image_step_bytes`.
    void undo_eight(const std::uint8_t* filtered,
                    std::size_t step_bytes,
                    const std::uint8_t* above,
                    std::uint8_t* row,
                    std::size_t image_step_bytes);

private:
    int width_;
    // Eight bytes for each step: pixel u of row k is byte k of step u + k. Bytes of `filtered_`
    // that are no pixel stay 0.
    std::vector<std::uint8_t> filtered_;
    std::vector<std::uint8_t> pixels_;
};

}  // namespace divemesh::dive
