#include "worker/stereo/refine_disparity.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <vector>

#include "worker/lanes.hpp"
#include "worker/stereo/running_sums.hpp"

namespace divemesh::worker {
namespace {

constexpr int kSmoothRadius = 2;       // in strides
constexpr float kLargestSlope = 1.0F;  // disparity per pixel; steeper is an edge
constexpr int kWideStride_px = 3;
constexpr float kCertain_px = 0.15F;  // a disparity this well known is left as it is
constexpr int kWindowRadius_px = 4;
constexpr int kWindowRows = 2 * kWindowRadius_px + 1;
constexpr float kFirstGate_px = 0.8F;
constexpr float kSecondGate_px = 0.4F;
constexpr float kLargestStep_px = 0.8F;
constexpr int kGreyScale = 16;    // grey values are kept in 1/16
constexpr int kLeastPixels = 12;  // known ones of the 81 of a window
// Variances, in squares of those grey values.
constexpr float kLeastNoise = kGreyScale * kGreyScale / 12.0F;  // rounding to grey values
constexpr float kGainPrior = 100.0F * kGreyScale * kGreyScale;  // noise of 1, gains within 0.1
// Of the noise of e: what is in the mean gradient of two pictures read through B-splines, whose
// weights for e are (1 4 1)/6 and for a gradient (1 4 0 -4 -1)/12.
constexpr float kGradientNoise = 0.118F;
// A B-spline correlates the noise of neighbours: 1 + 2 (4/9 + 1/18) for what varies little.
constexpr float kCorrelatedNoise = 2.0F;
constexpr float kLeastTexture = 0.5F;  // of the gradient's energy that is not noise

// Mirror pairs of a pixel's neighbours that lie on one plane with it, within its gate, are averaged
// with it. `rows`: five, `stride` apart, as the neighbours within each are. `taken`: how many
// pixels the mean is over.
DIVEMESH_INLINE_BODY void smooth_row_body(
    const float* const* rows, const float* gates, int stride, int width, float* out, float* taken) {
    const int reach = kSmoothRadius * stride;
    for (int start = reach; start < width - reach; start += kLanes) {
        // The last eight overlap the ones before.
        const int x = std::min(start, width - reach - kLanes);
        const Floats center = load(rows[kSmoothRadius] + x);
        const Floats gate = load(gates + x);
        if (!any(gate > 0.0F)) continue;
        Floats sum = {};
        Floats count = {};
        for (int dy = 0; dy <= kSmoothRadius; ++dy) {
            for (int dx = -kSmoothRadius; dx <= kSmoothRadius; ++dx) {
                if (dy == 0 && dx <= 0) continue;
                const Floats ahead = load(rows[kSmoothRadius + dy] + x + dx * stride);
                const Floats behind = load(rows[kSmoothRadius - dy] + x - dx * stride);
                const Floats largest =
                    gate + kLargestSlope * static_cast<float>(stride * std::max(dy, std::abs(dx)));
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
        store(taken + x, 1.0F + count);
    }
}

void smooth_row(
    const float* const* rows, const float* gates, int stride, int width, float* out, float* taken) {
    smooth_row_body(rows, gates, stride, width, out, taken);
}
DIVEMESH_FOR_AVX2 void smooth_row_avx2(
    const float* const* rows, const float* gates, int stride, int width, float* out, float* taken) {
    smooth_row_body(rows, gates, stride, width, out, taken);
}

// The sums of the normal equations, per pixel: g the gradient, r the warped right image, e left
// minus r.
enum Term { kCount, kG, kR, kE, kGG, kGR, kRR, kGE, kRE, kEE, kNumTerms };

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
    std::int32_t* __restrict t_ee = terms[kEE];
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
        t_ee[x] = e * e;
    }
}

// Least squares for the step s and the gain a of e = -g s + a r + b, a held near zero. What the fit
// leaves of e is the noise of both pictures, whatever its source: it tells how much of the
// gradient's energy is noise too, which would shorten the step, and how well s is known.
DIVEMESH_INLINE_BODY void step_body(const float* const (&sums)[kNumTerms],
                                    int width,
                                    float* disparity,
                                    float* sigma) {
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
        const Floats c_rr = sum(kRR) - r * r * inverse + kGainPrior;
        const Floats c_ge = sum(kGE) - g * e * inverse;
        const Floats c_re = sum(kRE) - r * e * inverse;
        const Floats c_ee = sum(kEE) - e * e * inverse;
        const Floats all = largest_of(c_gg - c_gr * c_gr / c_rr, splat(1.0F));
        const Floats slope = c_ge - c_gr * c_re / c_rr;
        const Floats rest = c_ee - c_re * c_re / c_rr - slope * slope / all;
        const Floats noise =
            largest_of(rest / largest_of(n - 3.0F, splat(1.0F)), splat(kLeastNoise));
        const Floats information = all - n * (kGradientNoise * noise);
        const Floats known = largest_of(information, splat(1.0F));
        const Floats step = -slope / known;
        const Floats d = load(disparity + x);
        const Masks good = (d > 0.0F) & (n >= static_cast<float>(kLeastPixels)) &
                           (all > 0.05F * c_gg) & (information > kLeastTexture * all);
        // What the vector before has done already, where the last ones overlap, is done once.
        const Masks now = kLaneNumbers >= start - x;
        const Floats stepped = d + where(good & now & (size_of(step) < kLargestStep_px), step);
        const Floats uncertain = square_root(kCorrelatedNoise * noise / known);
        store(disparity + x, stepped);
        store(sigma + x, where(good, largest_of(uncertain, splat(1e-3F))));
    }
}

struct StepKernels {
    void (*fill_terms)(const std::uint8_t*,
                       const Reading&,
                       int,
                       std::int32_t* const (&)[kNumTerms]);
    void (*step)(const float* const (&)[kNumTerms], int, float*, float*);
};

void fill_terms(const std::uint8_t* left,
                const Reading& reading,
                int width,
                std::int32_t* const (&terms)[kNumTerms]) {
    fill_terms_body(left, reading, width, terms);
}
void step(const float* const (&sums)[kNumTerms], int width, float* disparity, float* sigma) {
    step_body(sums, width, disparity, sigma);
}
DIVEMESH_FOR_AVX2 void fill_terms_avx2(const std::uint8_t* left,
                                       const Reading& reading,
                                       int width,
                                       std::int32_t* const (&terms)[kNumTerms]) {
    fill_terms_body(left, reading, width, terms);
}
DIVEMESH_FOR_AVX2 void step_avx2(const float* const (&sums)[kNumTerms],
                                 int width,
                                 float* disparity,
                                 float* sigma) {
    step_body(sums, width, disparity, sigma);
}

struct Refined {
    cv::Mat disparity_px;
    cv::Mat sigma_px;  // CV_32F; 0: noise alone
};

// One step for every pixel.
Refined lucas_kanade_step(const cv::Mat& left,
                          const cv::Mat& right,
                          const cv::Mat& disparity,
                          Instructions instructions) {
    const StepKernels kernels = instructions == Instructions::Baseline
                                    ? StepKernels{fill_terms, step}
                                    : StepKernels{fill_terms_avx2, step_avx2};
    const int width = left.cols;
    Refined refined{disparity.clone(), cv::Mat(disparity.size(), CV_32F, cv::Scalar(0.0))};
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
        const int center = y - kWindowRadius_px;
        kernels.step(sums,
                     width,
                     refined.disparity_px.ptr<float>(center),
                     refined.sigma_px.ptr<float>(center));
    }
    return refined;
}

struct Smoothing {
    cv::Mat gates_px;  // CV_32F, of each pixel, or one row for all
    int stride_px;
};

struct Smoothed {
    cv::Mat disparity_px;
    cv::Mat num_taken;
};

Smoothed smooth(const cv::Mat& disparity_px,
                const Smoothing& smoothing,
                Instructions instructions) {
    const auto smooth_one = instructions == Instructions::Baseline ? smooth_row : smooth_row_avx2;
    const int stride = smoothing.stride_px;
    const int reach = kSmoothRadius * stride;
    Smoothed result{disparity_px.clone(), cv::Mat(disparity_px.size(), CV_32F, cv::Scalar(1.0))};
    if (disparity_px.cols < 2 * reach + kLanes) return result;
    for (int y = reach; y < disparity_px.rows - reach; ++y) {
        const float* rows[2 * kSmoothRadius + 1];
        for (int i = 0; i <= 2 * kSmoothRadius; ++i)
            rows[i] = disparity_px.ptr<float>(y + (i - kSmoothRadius) * stride);
        smooth_one(rows,
                   smoothing.gates_px.ptr<float>(smoothing.gates_px.rows > 1 ? y : 0),
                   stride,
                   disparity_px.cols,
                   result.disparity_px.ptr<float>(y),
                   result.num_taken.ptr<float>(y));
    }
    return result;
}

// An uncertain disparity is looked for on the plane of its wider surroundings, within two standard
// deviations. The deviation falls as the mean is over more windows that do not overlap.
void smooth_uncertain(Refined& refined, Instructions instructions) {
    constexpr float kReach_px = 2 * kSmoothRadius * kWideStride_px + kWindowRows;
    constexpr float kMostWindows = kReach_px * kReach_px / (kWindowRows * kWindowRows);
    constexpr float kMostOthers = (2 * kSmoothRadius + 1) * (2 * kSmoothRadius + 1) - 1;
    cv::Mat gates = cv::min(2.0F * refined.sigma_px, kFirstGate_px);
    gates.setTo(0.0, refined.sigma_px <= kCertain_px);
    const Smoothed wide = smooth(refined.disparity_px, {gates, kWideStride_px}, instructions);
    refined.disparity_px = wide.disparity_px;
    float* sigma = refined.sigma_px.ptr<float>();
    const float* num_taken = wide.num_taken.ptr<float>();
    for (std::size_t i = 0; i < refined.sigma_px.total(); ++i) {
        if (num_taken[i] <= 1.0F) continue;
        const float others = (num_taken[i] - 1.0F) / kMostOthers;
        sigma[i] /= std::sqrt(1.0F + (kMostWindows - 1.0F) * others);
    }
}

}  // namespace

cv::Mat smooth_on_plane(const cv::Mat& disparity_px, float gate_px, Instructions instructions) {
    const cv::Mat gates(1, disparity_px.cols, CV_32F, cv::Scalar(gate_px));
    return smooth(disparity_px, {gates, 1}, instructions).disparity_px;
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

cv::Mat refine_disparity(const cv::Mat& left,
                         const cv::Mat& right,
                         cv::Mat& disparity_px,
                         Instructions instructions) {
    if (left.cols < kWindowRows || left.rows < kWindowRows)
        return {disparity_px.size(), CV_32F, cv::Scalar(0.0)};
    fill_pinholes(disparity_px);
    const cv::Mat smooth = smooth_on_plane(disparity_px, kFirstGate_px, instructions);
    Refined refined = lucas_kanade_step(left, right, smooth, instructions);
    refined.disparity_px = smooth_on_plane(refined.disparity_px, kSecondGate_px, instructions);
    smooth_uncertain(refined, instructions);
    refined.disparity_px.setTo(0.0, refined.sigma_px <= 0.0F);
    disparity_px = refined.disparity_px;
    return refined.sigma_px;
}

}  // namespace divemesh::worker
