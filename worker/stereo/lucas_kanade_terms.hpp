#pragma once

#include <cstdint>
#include <vector>

#include "worker/base/instructions.hpp"

namespace divemesh::stereo {

// The terms of a Lucas-Kanade step's normal equations, per pixel: g the gradient along the row, r
// the right image at the disparity's position, e left minus r. Grey values in 1 / kGreyScale, r
// relative to the middle of their range.
using Term = int;
inline constexpr Term kCount = 0;
inline constexpr Term kG = 1;
inline constexpr Term kR = 2;
inline constexpr Term kE = 3;
inline constexpr Term kGG = 4;
inline constexpr Term kGR = 5;
inline constexpr Term kRR = 6;
inline constexpr Term kGE = 7;
inline constexpr Term kRE = 8;
inline constexpr Term kEE = 9;
inline constexpr Term kNumTerms = 10;

inline constexpr int kGreyScale = 16;
inline constexpr int kWindowRadius_px = 4;
inline constexpr int kWindow_px = 2 * kWindowRadius_px + 1;

// One row of a rectified pair and the disparities of its left image; <= 0: unknown.
struct GreyRow {
    const std::uint8_t* left;
    const std::uint8_t* right;
    const float* disparity_px;
};

// Column sums of the terms over the last kWindow_px rows. They are integers and therefore exact.
// Rows have at least 8 pixels.
class LucasKanadeTerms {
public:
    explicit LucasKanadeTerms(base::Instructions instructions) : instructions_(instructions) {}

    // Starts a new image; call it before its first row.
    void begin(int width);
    void add_row(const GreyRow& row);
    void add_empty_row();
    // Returns the sums by column, with zeros before the first and after the last, as many as a
    // window and a vector need.
    const std::int32_t* columns(Term term) const {
        return columns_[static_cast<std::size_t>(term)].data() + kMargin_px;
    }

private:
    static constexpr int kMargin_px = 24;

    // Where the right image is read: six pixels, the third of which is the last one before the
    // position, and the distance of the position behind it.
    struct Reading {
        std::vector<std::uint32_t> first;  // the first four pixels
        std::vector<std::uint32_t> last;   // the last two
        std::vector<float> part;           // px
        std::vector<std::int32_t> known;   // 0 or 1
    };
    // g, r, e and whether they are known.
    using Values = std::vector<std::int16_t>;

    void read_right(const GreyRow& row);
    void exchange();

    base::Instructions instructions_;
    int width_ = 0;
    std::size_t oldest_ = 0;  // index into rows_
    std::vector<std::uint8_t> left_;
    Reading reading_;
    Values rows_[kWindow_px][4];
    std::vector<std::int32_t> columns_[kNumTerms];
};

}  // namespace divemesh::stereo
