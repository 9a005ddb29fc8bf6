#include "worker/stereo/refine_disparity.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <vector>

#include "worker/lanes.hpp"
#include "worker/stereo/disparity_sigma.hpp"
#include "worker/stereo/running_sums.hpp"

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

// Mirror pairs of a pixel's neighbours that lie on one plane with it, within `gate`, are averaged
// with it. `rows`: those from kSmoothRadius_px above to as many below.
DIVEMESH_INLINE_BODY void smooth_row_body(const float* const* rows,
                                          float gate,
                                          int width,
                                          float* out) {
    for (int start = kSmoothRadius_px; start < width - kSmoothRadius_px; start += kLanes) {
        // The last eight overlap the ones before.
        const int x = std::min(start, width - kSmoothRadius_px - kLanes);
        const Floats center = load(rows[kSmoothRadius_px] + x);
        Floats sum = {};
        Floats count = {};
        for (int dy = 0; dy <= kSmoothRadius_px; ++dy) {
            for (int dx = -kSmoothRadius_px; dx <= kSmoothRadius_px; ++dx) {
                if (dy == 0 && dx <= 0) continue;
                const Floats ahead = load(rows[kSmoothRadius_px + dy] + x + dx);
                const Floats behind = load(rows[kSmoothRadius_px - dy] + x - dx);
                const float largest =
                    gate + kLargestSlope * static_cast<float>(std::max(dy, std::abs(dx)));
                const Floats up = ahead - center;
                const Floats down = behind - center;
                const Masks on_plane = (ahead > 0.0F) & (behind > 0.0F) & (size_of(up) < largest) &
                                       (size_of(down) < largest) &
                                       (size_of(up + down) < 2.0F * gate);
                sum += where(on_plane, up + down);
                count += where(on_plane, splat(2.0F));
            }
        }
        const Floats smooth = center + where(center > 0.0F, sum / (1.0F + count));
        store(out + x, smooth);
    }
}

void smooth_row(const float* const* rows, float gate, int width, float* out) {
    smooth_row_body(rows, gate, width, out);
}
DIVEMESH_FOR_AVX2 void smooth_row_avx2(const float* const* rows,
                                       float gate,
                                       int width,
                                       float* out) {
    smooth_row_body(rows, gate, width, out);
}

// The sums of the normal equations, per pixel: g the gradient, r the warped right image, e left
// minus r.
enum Term { kCount, kG, kR, kE, kGG, kGR, kRR, kGE, kRE, kNumTerms };

struct GreyRow {
    const std::uint8_t* left;
    const std::uint8_t* right;
    const float* disparity;
};

// Where the right picture is read: eight pixels, of which the third is the last one before that
// place, and how far behind it the place is.
struct Reading {
    std::vector<std::uint32_t> first;  // four of the pixels
    std::vector<std::uint32_t> last;
    std::vector<float> part;          // px
    std::vector<std::int32_t> known;  // 0 or 1
};

constexpr int kReadBefore_px = 2;  // of the pixels that are looked at, and as many behind
constexpr int kReadBehind_px = 5;

void read_right(const GreyRow& in, int width, Reading& reading) {
    const int last = width - 1 - kReadBehind_px;
    for (int x = kReadBefore_px; x < width - kReadBefore_px; ++x) {
        const float at = static_cast<float>(x) - in.disparity[x];
        const int k = std::clamp(static_cast<int>(at), kReadBefore_px, last);
        std::memcpy(&reading.first[x], in.right + k - kReadBefore_px, sizeof(std::uint32_t));
        std::memcpy(&reading.last[x], in.right + k + 2, sizeof(std::uint32_t));
        reading.part[x] = at - static_cast<float>(k);
        reading.known[x] = static_cast<int>(in.disparity[x] > 0.0F) &
                           static_cast<int>(at >= static_cast<float>(kReadBefore_px)) &
                           static_cast<int>(at < static_cast<float>(last + 1));
    }
}

// Terms of one row. Both images are read through a cubic B-spline, whose phase hardly depends on
// the place between two pixels: a bilinear or a cubic (Keys) one draws fine texture up to 0.05 px
// toward the nearest pixel (Schreier, Braasch and Sutton 2000). The gradient is the mean of both
// images', which halves what noise adds to it; central differences, whose noise has nothing in
// common with that of e.
DIVEMESH_INLINE_BODY void fill_terms_body(const std::uint8_t* left,
                                          const Reading& reading,
                                          int width,
                                          std::int32_t* const (&terms)[kNumTerms]) {
    const std::uint32_t* __restrict first_ = reading.first.data();
    const std::uint32_t* __restrict last_ = reading.last.data();
    const float* __restrict part_ = reading.part.data();
    const std::int32_t* __restrict known_ = reading.known.data();
    std::int32_t* __restrict count = terms[kCount];
    std::int32_t* __restrict t_g = terms[kG];
    std::int32_t* __restrict t_r = terms[kR];
    std::int32_t* __restrict t_e = terms[kE];
    std::int32_t* __restrict t_gg = terms[kGG];
    std::int32_t* __restrict t_gr = terms[kGR];
    std::int32_t* __restrict t_rr = terms[kRR];
    std::int32_t* __restrict t_ge = terms[kGE];
    std::int32_t* __restrict t_re = terms[kRE];
    constexpr float kScale = kGreyScale;
    for (int x = kReadBefore_px; x < width - kReadBefore_px; ++x) {
        const auto grey = [](std::uint32_t four, int i) __attribute__((always_inline)) {
            return static_cast<float>(static_cast<std::int32_t>(four >> (8 * i) & 255U));
        };
        const float p0 = grey(first_[x], 0);
        const float p1 = grey(first_[x], 1);
        const float p2 = grey(first_[x], 2);
        const float p3 = grey(first_[x], 3);
        const float p4 = grey(last_[x], 0);
        const float p5 = grey(last_[x], 1);
        const float t = part_[x];
        const float rest = 1.0F - t;
        const float w1 = rest * rest * rest * (1.0F / 6.0F);
        const float w4 = t * t * t * (1.0F / 6.0F);
        const float w2 = 2.0F / 3.0F + t * t * (0.5F * t - 1.0F);
        const float w3 = 1.0F - w1 - w2 - w4;
        const float warped = w1 * p1 + w2 * p2 + w3 * p3 + w4 * p4;
        const float gradient_right =  // times two
            w1 * (p2 - p0) + w2 * (p3 - p1) + w3 * (p4 - p2) + w4 * (p5 - p3);
        const int left_6 = left[x - 1] + 4 * left[x] + left[x + 1];
        const int gradient_left_12 = left[x + 2] - left[x - 2] + 4 * (left[x + 1] - left[x - 1]);
        const float smooth_left = static_cast<float>(left_6) * (1.0F / 6.0F);
        const float gradient_left = static_cast<float>(gradient_left_12) * (1.0F / 6.0F);
        const std::int32_t known = known_[x];
        const std::int32_t g =
            known * static_cast<std::int32_t>(0.25F * kScale * (gradient_left + gradient_right));
        const std::int32_t e = known * static_cast<std::int32_t>(kScale * (smooth_left - warped));
        const std::int32_t r = known * static_cast<std::int32_t>(kScale * (warped - 128.0F));
        count[x] = known;
        t_g[x] = g;
        t_r[x] = r;
        t_e[x] = e;
        t_gg[x] = g * g;
        t_gr[x] = g * r;
        t_rr[x] = r * r;
        t_ge[x] = g * e;
        t_re[x] = r * e;
    }
}

// Least squares for the step s and the gain a of e = -g s + a r + b, a held near zero.
DIVEMESH_INLINE_BODY void step_body(const float* const (&sums)[kNumTerms],
                                    float gain_prior,
                                    int width,
                                    float* disparity) {
    for (int start = kWindowRadius_px; start < width - kWindowRadius_px; start += kLanes) {
        const int x = std::min(start, width - kWindowRadius_px - kLanes);
        const auto sum = [&](Term term) __attribute__((always_inline)) {
            return load(sums[term] + x);
        };
        const Floats n = sum(kCount);
        const Floats g = sum(kG);
        const Floats r = sum(kR);
        const Floats e = sum(kE);
        const Floats inverse = 1.0F / largest_of(n, splat(1.0F));
        const Floats c_gg = sum(kGG) - g * g * inverse;
        const Floats c_gr = sum(kGR) - g * r * inverse;
        const Floats c_rr = sum(kRR) - r * r * inverse + gain_prior;
        const Floats c_ge = sum(kGE) - g * e * inverse;
        const Floats c_re = sum(kRE) - r * e * inverse;
        const Floats information = c_gg - c_gr * c_gr / c_rr;
        const Floats step = -(c_ge - c_gr * c_re / c_rr) / largest_of(information, splat(1.0F));
        const Floats d = load(disparity + x);
        // What the vector before has done already, where the last ones overlap, is done once.
        const Masks good = (d > 0.0F) & (n >= static_cast<float>(kLeastPixels)) &
                           (information > 0.05F * c_gg) & (information > 0.0F) &
                           (size_of(step) < kLargestStep_px) & (kLaneNumbers >= start - x);
        const Floats stepped = d + where(good, step);
        store(disparity + x, stepped);
    }
}

struct StepKernels {
    void (*fill_terms)(const std::uint8_t*,
                       const Reading&,
                       int,
                       std::int32_t* const (&)[kNumTerms]);
    void (*step)(const float* const (&)[kNumTerms], float, int, float*);
};

void fill_terms(const std::uint8_t* left,
                const Reading& reading,
                int width,
                std::int32_t* const (&terms)[kNumTerms]) {
    fill_terms_body(left, reading, width, terms);
}
void step(const float* const (&sums)[kNumTerms], float gain_prior, int width, float* disparity) {
    step_body(sums, gain_prior, width, disparity);
}
DIVEMESH_FOR_AVX2 void fill_terms_avx2(const std::uint8_t* left,
                                       const Reading& reading,
                                       int width,
                                       std::int32_t* const (&terms)[kNumTerms]) {
    fill_terms_body(left, reading, width, terms);
}
DIVEMESH_FOR_AVX2 void step_avx2(const float* const (&sums)[kNumTerms],
                                 float gain_prior,
                                 int width,
                                 float* disparity) {
    step_body(sums, gain_prior, width, disparity);
}

// One step for every pixel.
cv::Mat lucas_kanade_step(const cv::Mat& left,
                          const cv::Mat& right,
                          const cv::Mat& disparity,
                          Instructions instructions) {
    const StepKernels kernels = instructions == Instructions::Baseline
                                    ? StepKernels{fill_terms, step}
                                    : StepKernels{fill_terms_avx2, step_avx2};
    const int width = left.cols;
    const auto noise = static_cast<float>(image_noise(left)) * kGreyScale / kGainSigma;
    cv::Mat refined = disparity.clone();
    RunningSums window(kNumTerms, width, kWindowRadius_px, instructions);
    Reading reading{std::vector<std::uint32_t>(width),
                    std::vector<std::uint32_t>(width),
                    std::vector<float>(width),
                    std::vector<std::int32_t>(width)};
    for (int y = 0; y < left.rows; ++y) {
        read_right({left.ptr<std::uint8_t>(y), right.ptr<std::uint8_t>(y), disparity.ptr<float>(y)},
                   width,
                   reading);
        std::int32_t* terms[kNumTerms];
        for (int term = 0; term < kNumTerms; ++term) terms[term] = window.next(term).data();
        kernels.fill_terms(left.ptr<std::uint8_t>(y), reading, width, terms);
        window.add_row();
        if (!window.whole()) continue;
        const float* sums[kNumTerms];
        for (int term = 0; term < kNumTerms; ++term) sums[term] = window.sums(term).data();
        kernels.step(sums, noise * noise, width, refined.ptr<float>(y - kWindowRadius_px));
    }
    return refined;
}

}  // namespace

cv::Mat smooth_on_plane(const cv::Mat& disparity_px, float gate_px, Instructions instructions) {
    const auto smooth_one = instructions == Instructions::Baseline ? smooth_row : smooth_row_avx2;
    cv::Mat smooth = disparity_px.clone();
    if (disparity_px.cols < 2 * kSmoothRadius_px + kLanes) return smooth;
    for (int y = kSmoothRadius_px; y < disparity_px.rows - kSmoothRadius_px; ++y) {
        const float* rows[2 * kSmoothRadius_px + 1];
        for (int i = 0; i <= 2 * kSmoothRadius_px; ++i)
            rows[i] = disparity_px.ptr<float>(y + i - kSmoothRadius_px);
        smooth_one(rows, gate_px, disparity_px.cols, smooth.ptr<float>(y));
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
