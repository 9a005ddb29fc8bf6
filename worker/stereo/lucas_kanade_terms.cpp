#include "worker/stereo/lucas_kanade_terms.hpp"

#include <algorithm>
#include <cstring>

#include "worker/base/lanes.hpp"

namespace divemesh::stereo {
namespace {

constexpr int kReadBefore_px = 2;  // x offset of the first and the last pixel read
constexpr int kReadBehind_px = 5;

using Integers = base::Masks;  // 32 bits

struct Read {
    const std::uint8_t* left;
    const std::uint32_t* first;
    const std::uint32_t* last;
    const float* part;
    const std::int32_t* known;
};

DIVEMESH_INLINE_BODY Integers load_bytes(const std::uint8_t* from) {
    using Eight = std::uint8_t __attribute__((vector_size(base::kLanes)));
    return __builtin_convertvector(base::load_lanes<Eight>(from), Integers);
}
DIVEMESH_INLINE_BODY Integers load_shorts(const std::int16_t* from) {
    return __builtin_convertvector(base::load_lanes<base::SignedShorts>(from), Integers);
}
DIVEMESH_INLINE_BODY base::Floats to_floats(Integers values) {
    return __builtin_convertvector(values, base::Floats);
}
DIVEMESH_INLINE_BODY base::Floats byte_of(Integers words, int i) {
    return to_floats((words >> (8 * i)) & 255);
}

struct Values {
    Integers g, r, e, known;
};

// Both images are interpolated by a cubic B-spline, whose phase hardly depends on the position
// between two pixels: bilinear or cubic (Keys) interpolation pulls fine texture by up to 0.05 px
// towards the nearest pixel (Schreier, Braasch and Sutton 2000). The gradient is the mean of both
// images', which halves its noise. It uses central differences, whose noise is uncorrelated with
// that of e.
DIVEMESH_INLINE_BODY Values values_at(const Read& in, int x) {
    constexpr float kScale = kGreyScale;
    const auto first = base::load_lanes<Integers>(in.first + x);
    const auto last = base::load_lanes<Integers>(in.last + x);
    const base::Floats p0 = byte_of(first, 0), p1 = byte_of(first, 1), p2 = byte_of(first, 2);
    const base::Floats p3 = byte_of(first, 3), p4 = byte_of(last, 0), p5 = byte_of(last, 1);
    const base::Floats t = base::load(in.part + x);
    const base::Floats rest = 1.0F - t;
    const base::Floats w1 = rest * rest * rest * (1.0F / 6.0F);
    const base::Floats w4 = t * t * t * (1.0F / 6.0F);
    const base::Floats w2 = 2.0F / 3.0F + t * t * (0.5F * t - 1.0F);
    const base::Floats w3 = 1.0F - w1 - w2 - w4;
    const base::Floats warped = w1 * p1 + w2 * p2 + w3 * p3 + w4 * p4;
    const base::Floats gradient_right =  // times two
        w1 * (p2 - p0) + w2 * (p3 - p1) + w3 * (p4 - p2) + w4 * (p5 - p3);
    Integers left[5];
    for (int i = 0; i < 5; ++i) left[i] = load_bytes(in.left + x + i - 2);
    const base::Floats smooth_left = to_floats(left[1] + 4 * left[2] + left[3]) * (1.0F / 6.0F);
    const base::Floats gradient_left =
        to_floats(left[4] - left[0] + 4 * (left[3] - left[1])) * (1.0F / 6.0F);
    const auto known = base::load_lanes<Integers>(in.known + x);
    return {known * base::to_integers(0.25F * kScale * (gradient_left + gradient_right)),
            known * base::to_integers(kScale * (warped - 128.0F)),
            known * base::to_integers(kScale * (smooth_left - warped)),
            known};
}

// Replaces the values of the oldest row by those of a new one, in `rows` and in the sums.
DIVEMESH_INLINE_BODY void exchange_row(const Read& in,
                                       int width,
                                       std::int16_t* const (&rows)[4],
                                       std::int32_t* const (&columns)[kNumTerms]) {
    for (int x = 0; x < width; x += base::kLanes) {
        const Values now = values_at(in, x);
        const Values old = {load_shorts(rows[0] + x),
                            load_shorts(rows[1] + x),
                            load_shorts(rows[2] + x),
                            load_shorts(rows[3] + x)};
        base::store(rows[0] + x, __builtin_convertvector(now.g, base::SignedShorts));
        base::store(rows[1] + x, __builtin_convertvector(now.r, base::SignedShorts));
        base::store(rows[2] + x, __builtin_convertvector(now.e, base::SignedShorts));
        base::store(rows[3] + x, __builtin_convertvector(now.known, base::SignedShorts));
        const auto add = [&](Term term, Integers change) __attribute__((always_inline)) {
            base::store(columns[term] + x, base::load_lanes<Integers>(columns[term] + x) + change);
        };
        add(kCount, now.known - old.known);
        add(kG, now.g - old.g);
        add(kR, now.r - old.r);
        add(kE, now.e - old.e);
        add(kGG, now.g * now.g - old.g * old.g);
        add(kGR, now.g * now.r - old.g * old.r);
        add(kRR, now.r * now.r - old.r * old.r);
        add(kGE, now.g * now.e - old.g * old.e);
        add(kRE, now.r * now.e - old.r * old.e);
        add(kEE, now.e * now.e - old.e * old.e);
    }
}

}  // namespace

void LucasKanadeTerms::begin(int width) {
    width_ = width;
    const auto padded = static_cast<std::size_t>(width) + std::size_t{2} * kMargin_px;
    left_.assign(padded, 0);
    reading_.first.assign(padded, 0);
    reading_.last.assign(padded, 0);
    reading_.part.assign(padded, 0.0F);
    reading_.known.assign(padded, 0);
    for (auto& row : rows_)
        for (Values& values : row) values.assign(padded, 0);
    for (auto& column : columns_) column.assign(padded, 0);
}

void LucasKanadeTerms::add_row(const GreyRow& row) {
    std::copy_n(row.left, width_, left_.data() + kMargin_px);
    read_right(row);
    exchange();
}

void LucasKanadeTerms::add_empty_row() {
    std::fill(reading_.known.begin(), reading_.known.end(), 0);
    exchange();
}

void LucasKanadeTerms::read_right(const GreyRow& row) {
    const int last = width_ - 1 - kReadBehind_px;
    for (int x = kReadBefore_px; x < width_ - kReadBefore_px; ++x) {
        const float at = static_cast<float>(x) - row.disparity_px[x];
        const int k = std::clamp(static_cast<int>(at), kReadBefore_px, last);
        std::memcpy(&reading_.first[x], row.right + k - kReadBefore_px, sizeof(std::uint32_t));
        std::memcpy(&reading_.last[x], row.right + k + 2, sizeof(std::uint32_t));
        reading_.part[x] = at - static_cast<float>(k);
        reading_.known[x] = static_cast<int>(row.disparity_px[x] > 0.0F) &
                            static_cast<int>(at >= static_cast<float>(kReadBefore_px)) &
                            static_cast<int>(at < static_cast<float>(last + 1));
    }
}

void LucasKanadeTerms::exchange() {
    const Read read{left_.data() + kMargin_px,
                    reading_.first.data(),
                    reading_.last.data(),
                    reading_.part.data(),
                    reading_.known.data()};
    std::int16_t* rows[4];
    for (int i = 0; i < 4; ++i) rows[i] = rows_[oldest_][i].data();
    std::int32_t* columns[kNumTerms];
    for (int term = 0; term < kNumTerms; ++term) columns[term] = columns_[term].data() + kMargin_px;
    base::compiled_for<exchange_row>(instructions_)(read, width_, rows, columns);
    oldest_ = (oldest_ + 1) % kWindow_px;
}

}  // namespace divemesh::stereo
