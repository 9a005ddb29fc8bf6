#include "worker/stereo/refine_disparity.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "worker/stereo/disparity_sigma.hpp"

namespace divemesh::worker {
namespace {

constexpr int kSmoothRadius_px = 2;
constexpr float kLargestSlope = 1.0F;  // disparity per pixel; steeper is an edge
constexpr int kWindowRadius_px = 4;
constexpr int kWindowRows = 2 * kWindowRadius_px + 1;
constexpr float kFirstGate_px = 0.8F;
constexpr float kSecondGate_px = 0.4F;
constexpr float kLargestStep_px = 0.8F;
constexpr float kGainSigma = 0.1F;  // how far the cameras' gains are expected to differ
constexpr int kGreyScale = 16;      // grey values are kept in 1/16
constexpr int kLeastPixels = 12;    // known ones of the 81 of a window

struct MirrorPair {
    const float* ahead;
    const float* behind;
    float largest_step;
};

DIVEMESH_INLINE_BODY void add_pair_body(
    const float* center, const MirrorPair& pair, float gate, int num, float* sums) {
    const float* __restrict c = center;
    const float* __restrict a = pair.ahead;
    const float* __restrict b = pair.behind;
    float* __restrict sum = sums;
    float* __restrict count = sums + num;
    for (int x = 0; x < num; ++x) {
        const float up = a[x] - c[x];
        const float down = b[x] - c[x];
        const bool both = (a[x] > 0.0F) & (b[x] > 0.0F) & (std::abs(up) < pair.largest_step) &
                          (std::abs(down) < pair.largest_step) &
                          (std::abs(up + down) < 2.0F * gate);
        sum[x] += both ? up + down : 0.0F;
        count[x] += both ? 2.0F : 0.0F;
    }
}

void add_pair(const float* center, const MirrorPair& pair, float gate, int num, float* sums) {
    add_pair_body(center, pair, gate, num, sums);
}
DIVEMESH_FOR_AVX2 void add_pair_avx2(
    const float* center, const MirrorPair& pair, float gate, int num, float* sums) {
    add_pair_body(center, pair, gate, num, sums);
}

// The sums of the normal equations, per pixel: g the gradient, r the warped right image, e left
// minus r.
enum Term { kCount, kG, kR, kE, kGG, kGR, kRR, kGE, kRE, kNumTerms };
using Row = std::vector<std::int32_t>;
using Terms = std::array<Row, kNumTerms>;

struct GreyRow {
    const std::uint8_t* left;
    const std::uint8_t* right;
    const float* disparity;
};

// Terms of one row; the gradient is the mean of both images', which halves what noise adds to it.
void fill_terms(const GreyRow& in, int width, Terms& terms) {
    for (Row& row : terms) std::fill(row.begin(), row.end(), 0);
    for (int x = 1; x + 1 < width; ++x) {
        const float at = static_cast<float>(x) - in.disparity[x];
        if (in.disparity[x] <= 0.0F || at < 1.0F) continue;
        const auto fixed = static_cast<int>(at * kGreyScale);
        const int k = fixed / kGreyScale;
        if (k + 2 >= width) continue;
        const int part = fixed % kGreyScale;
        const std::uint8_t* p = in.right + k;
        const int gradient_left = kGreyScale * (in.left[x + 1] - in.left[x - 1]);
        const int gradient_right = (p[1] - p[-1]) * (kGreyScale - part) + (p[2] - p[0]) * part;
        const int g = (gradient_left + gradient_right) / 4;
        const int warped = p[0] * (kGreyScale - part) + p[1] * part;
        const int e = kGreyScale * in.left[x] - warped;
        const int r = warped - kGreyScale * 128;
        const std::int32_t values[kNumTerms] = {1, g, r, e, g * g, g * r, r * r, g * e, r * e};
        for (int term = 0; term < kNumTerms; ++term) terms[term][x] = values[term];
    }
}

DIVEMESH_INLINE_BODY void exchange_body(std::int32_t* sum_,
                                        const std::int32_t* entering_,
                                        const std::int32_t* leaving_,
                                        int num) {
    std::int32_t* __restrict sum = sum_;
    const std::int32_t* __restrict entering = entering_;
    const std::int32_t* __restrict leaving = leaving_;
    for (int x = 0; x < num; ++x) sum[x] += entering[x] - leaving[x];
}

DIVEMESH_INLINE_BODY void widen_body(const std::int32_t* column_, int num, float* window_) {
    const std::int32_t* __restrict column = column_;
    float* __restrict window = window_;
    for (int x = kWindowRadius_px; x < num - kWindowRadius_px; ++x) {
        std::int32_t sum = 0;
        for (int i = -kWindowRadius_px; i <= kWindowRadius_px; ++i) sum += column[x + i];
        window[x] = static_cast<float>(sum);
    }
}

// Least squares for the step s and the gain a of e = -g s + a r + b, a held near zero.
DIVEMESH_INLINE_BODY void step_body(const std::vector<float>* sums, float gain_prior, float* d_) {
    const float* __restrict n = sums[kCount].data();
    const float* __restrict g = sums[kG].data();
    const float* __restrict r = sums[kR].data();
    const float* __restrict e = sums[kE].data();
    const float* __restrict gg = sums[kGG].data();
    const float* __restrict gr = sums[kGR].data();
    const float* __restrict rr = sums[kRR].data();
    const float* __restrict ge = sums[kGE].data();
    const float* __restrict re = sums[kRE].data();
    float* __restrict d = d_;
    const int width = static_cast<int>(sums[kCount].size());
    for (int x = kWindowRadius_px; x < width - kWindowRadius_px; ++x) {
        const float inverse = 1.0F / std::max(1.0F, n[x]);
        const float c_gg = gg[x] - g[x] * g[x] * inverse;
        const float c_gr = gr[x] - g[x] * r[x] * inverse;
        const float c_rr = rr[x] - r[x] * r[x] * inverse + gain_prior;
        const float c_ge = ge[x] - g[x] * e[x] * inverse;
        const float c_re = re[x] - r[x] * e[x] * inverse;
        const float information = c_gg - c_gr * c_gr / c_rr;
        const float step = -(c_ge - c_gr * c_re / c_rr) / std::max(information, 1.0F);
        const bool good = (d[x] > 0.0F) & (n[x] >= kLeastPixels) & (information > 0.05F * c_gg) &
                          (information > 0.0F) & (std::abs(step) < kLargestStep_px);
        d[x] += good ? step : 0.0F;
    }
}

struct StepKernels {
    void (*exchange)(std::int32_t*, const std::int32_t*, const std::int32_t*, int);
    void (*widen)(const std::int32_t*, int, float*);
    void (*step)(const std::vector<float>*, float, float*);
};

void exchange(std::int32_t* sum, const std::int32_t* in, const std::int32_t* out, int num) {
    exchange_body(sum, in, out, num);
}
void widen(const std::int32_t* column, int num, float* window) { widen_body(column, num, window); }
void step(const std::vector<float>* sums, float prior, float* d) { step_body(sums, prior, d); }
DIVEMESH_FOR_AVX2 void exchange_avx2(std::int32_t* sum,
                                     const std::int32_t* in,
                                     const std::int32_t* out,
                                     int num) {
    exchange_body(sum, in, out, num);
}
DIVEMESH_FOR_AVX2 void widen_avx2(const std::int32_t* column, int num, float* window) {
    widen_body(column, num, window);
}
DIVEMESH_FOR_AVX2 void step_avx2(const std::vector<float>* sums, float prior, float* d) {
    step_body(sums, prior, d);
}

// One step for every pixel. Sums are integers and run down the image: exact, at any window size.
cv::Mat lucas_kanade_step(const cv::Mat& left,
                          const cv::Mat& right,
                          const cv::Mat& disparity,
                          Instructions instructions) {
    const StepKernels kernels = instructions == Instructions::Avx2
                                    ? StepKernels{exchange_avx2, widen_avx2, step_avx2}
                                    : StepKernels{exchange, widen, step};
    const int width = left.cols;
    const auto noise = static_cast<float>(image_noise(left)) * kGreyScale / kGainSigma;
    cv::Mat refined = disparity.clone();
    std::array<Terms, kWindowRows> rows;
    Terms columns;
    for (Terms& row : rows)
        for (Row& term : row) term.assign(width, 0);
    for (Row& term : columns) term.assign(width, 0);
    const Row nothing(width, 0);
    std::vector<float> sums[kNumTerms];
    for (auto& sum : sums) sum.assign(width, 0.0F);
    Terms entering = columns;
    for (int y = 0; y < left.rows; ++y) {
        fill_terms({left.ptr<std::uint8_t>(y), right.ptr<std::uint8_t>(y), disparity.ptr<float>(y)},
                   width,
                   entering);
        Terms& leaving = rows[y % kWindowRows];
        for (int term = 0; term < kNumTerms; ++term) {
            kernels.exchange(
                columns[term].data(), entering[term].data(), leaving[term].data(), width);
            std::swap(leaving[term], entering[term]);
            if (y + 1 >= kWindowRows) kernels.widen(columns[term].data(), width, sums[term].data());
        }
        if (y + 1 >= kWindowRows)
            kernels.step(sums, noise * noise, refined.ptr<float>(y - kWindowRadius_px));
    }
    return refined;
}

}  // namespace

cv::Mat smooth_on_plane(const cv::Mat& disparity_px, float gate_px, Instructions instructions) {
    const auto add = instructions == Instructions::Avx2 ? add_pair_avx2 : add_pair;
    cv::Mat smooth = disparity_px.clone();
    const int num = disparity_px.cols - 2 * kSmoothRadius_px;
    if (num <= 0) return smooth;
    std::vector<float> sums(2 * static_cast<std::size_t>(num));
    for (int y = kSmoothRadius_px; y < disparity_px.rows - kSmoothRadius_px; ++y) {
        const float* center = disparity_px.ptr<float>(y) + kSmoothRadius_px;
        std::fill(sums.begin(), sums.end(), 0.0F);
        for (int dy = 0; dy <= kSmoothRadius_px; ++dy)
            for (int dx = -kSmoothRadius_px; dx <= kSmoothRadius_px; ++dx) {
                if (dy == 0 && dx <= 0) continue;
                const float* ahead = disparity_px.ptr<float>(y + dy) + kSmoothRadius_px + dx;
                const float* behind = disparity_px.ptr<float>(y - dy) + kSmoothRadius_px - dx;
                const float reach = kLargestSlope * static_cast<float>(std::max(dy, std::abs(dx)));
                add(center, {ahead, behind, reach + gate_px}, gate_px, num, sums.data());
            }
        float* out = smooth.ptr<float>(y) + kSmoothRadius_px;
        for (int x = 0; x < num; ++x)
            if (center[x] > 0.0F) out[x] = center[x] + sums[x] / (1.0F + sums[num + x]);
    }
    return smooth;
}

void fill_pinholes(cv::Mat& disparity_px) {
    static constexpr int kPairs[8][2] = {
        {1, 0}, {0, 1}, {1, 1}, {1, -1}, {2, 0}, {0, 2}, {2, 1}, {1, 2}};
    const cv::Mat before = disparity_px.clone();
    for (int y = 2; y < before.rows - 2; ++y)
        for (int x = 2; x < before.cols - 2; ++x) {
            if (before.at<float>(y, x) > 0.0F) continue;
            float sum = 0.0F, least = 1e9F, largest = 0.0F;
            int num = 0;
            for (const auto& pair : kPairs) {
                const float a = before.at<float>(y + pair[1], x + pair[0]);
                const float b = before.at<float>(y - pair[1], x - pair[0]);
                if (a <= 0.0F || b <= 0.0F || std::abs(a - b) > 2.0F * kLargestSlope) continue;
                const float mean = 0.5F * (a + b);
                sum += mean;
                least = std::min(least, mean);
                largest = std::max(largest, mean);
                ++num;
            }
            if (num >= 3 && largest - least < kFirstGate_px)
                disparity_px.at<float>(y, x) = sum / static_cast<float>(num);
        }
}

void refine_disparity(const cv::Mat& left,
                      const cv::Mat& right,
                      cv::Mat& disparity_px,
                      Instructions instructions) {
    if (left.cols < kWindowRows || left.rows < kWindowRows) return;
    fill_pinholes(disparity_px);
    const cv::Mat smooth = smooth_on_plane(disparity_px, kFirstGate_px, instructions);
    const cv::Mat stepped = lucas_kanade_step(left, right, smooth, instructions);
    disparity_px = smooth_on_plane(stepped, kSecondGate_px, instructions);
}

}  // namespace divemesh::worker
