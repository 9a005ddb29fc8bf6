#pragma once

#include <cstdint>
#include <vector>

#include "worker/base/instructions.hpp"

namespace divemesh::stereo {

// Of the normal equations of a Lucas-Kanade step, per pixel: g the gradient along the row, r the
// right picture as read where the disparity says, e left minus r; grey values in 1 / kGreyScale,
// r from the middle of their range.
enum Term { kCount, kG, kR, kE, kGG, kGR, kRR, kGE, kRE, kEE, kNumTerms };

inline constexpr int kGreyScale = 16;
inline constexpr int kWindowRadius_px = 4;
inline constexpr int kWindow_px = 2 * kWindowRadius_px + 1;

// One row of a rectified pair and the disparity of its left picture; <= 0: unknown.
struct GreyRow {
    const std::uint8_t* left;
    const std::uint8_t* right;
    const float* disparity_px;
};

// Sums of the terms over the kWindow_px rows added last, column by column. Integers, so that they
// are exact. Of 8 pixels at least.
class LucasKanadeTerms {
public:
    explicit LucasKanadeTerms(base::Instructions instructions) : instructions_(instructions) {}

    // Before the first row of a picture.
    void begin(int width);
    void add_row(const GreyRow& row);
    void add_empty_row();
    // By column; as many zeros before the first and behind the last as a window and a vector need.
    const std::int32_t* columns(Term term) const {
        return columns_[static_cast<std::size_t>(term)].data() + kMargin_px;
    }

private:
    static constexpr int kMargin_px = 24;

    // Where the right picture is read: six pixels, of which the third is the last one before that
    // place, and how far behind it the place is.
    struct Reading {
        std::vector<std::uint32_t> first;  // four of the pixels
        std::vector<std::uint32_t> last;   // two
        std::vector<float> part;           // px
        std::vector<std::int32_t> known;   // 0 or 1
    };
    // g, r, e and whether they are known.
    using Values = std::vector<std::int16_t>;

    void read_right(const GreyRow& row);
    void exchange();

    base::Instructions instructions_;
    int width_ = 0;
    std::size_t oldest_ = 0;  // of rows_
    std::vector<std::uint8_t> left_;
    Reading reading_;
    Values rows_[kWindow_px][4];
    std::vector<std::int32_t> columns_[kNumTerms];
};

}  // namespace divemesh::stereo
