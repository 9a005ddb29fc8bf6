#include "worker/stereo/subpixel_refinement.hpp"

#include <numeric>

#include "worker/base/lanes.hpp"

namespace divemesh::stereo {
namespace {

constexpr float kMaxStep_px = 0.8F;
// Min number of known pixels in a window. The wide one needs only a quarter: it is for weak texture
// on a surface.
constexpr float kMinPixels = 12.0F;
constexpr float kMinWidePixels = 0.25F * 9 * kWindow_px * kWindow_px;
// Variances, in the squared unit of the stored grey values.
constexpr float kMinNoise = kGreyScale * kGreyScale / 12.0F;    // rounding to grey values
constexpr float kGainPrior = 100.0F * kGreyScale * kGreyScale;  // noise of 1, gains within 0.1
// The noise variance of the mean gradient, relative to that of e, for two images interpolated by
// B-splines with weights (1 4 1)/6 for e and (1 4 0 -4 -1)/12 for a gradient.
constexpr float kGradientNoise = 0.118F;
// A B-spline correlates the noise of neighbours: 1 + 2 (4/9 + 1/18) for slowly varying quantities.
constexpr float kCorrelatedNoise = 2.0F;
// Min energy of the gradient beyond that of noise alone: as much again (which chance matches do not
// reach over a window), and this many standard deviations.
constexpr float kMinTexture = 1.0F;
constexpr float kMinSignificance = 4.5F;

struct Fit {
    base::Floats step_px;
    base::Floats sigma_px;  // 0: not determined
};

// Solves for the step s and the gain a of e = -g s + a r + b by least squares, with a held near
// zero. The residual is the noise of both images, whatever its source. It tells how much of the
// gradient's energy is noise too, which would shorten the step, and how uncertain s is.
DIVEMESH_INLINE_BODY Fit fit_step(const base::Floats (&sums)[kNumTerms], float min_num_pixels) {
    const base::Floats n = sums[kCount];
    const base::Floats g = sums[kG], r = sums[kR], e = sums[kE];
    const base::Floats inverse = 1.0F / base::max(n, base::broadcast(1.0F));
    const base::Floats c_gg = sums[kGG] - g * g * inverse;
    const base::Floats c_gr = sums[kGR] - g * r * inverse;
    const base::Floats c_rr = sums[kRR] - r * r * inverse + kGainPrior;
    const base::Floats c_ge = sums[kGE] - g * e * inverse;
    const base::Floats c_re = sums[kRE] - r * e * inverse;
    const base::Floats c_ee = sums[kEE] - e * e * inverse;
    const base::Floats all = base::max(c_gg - c_gr * c_gr / c_rr, base::broadcast(1.0F));
    const base::Floats slope = c_ge - c_gr * c_re / c_rr;
    const base::Floats rest = c_ee - c_re * c_re / c_rr - slope * slope / all;
    const base::Floats noise =
        base::max(rest / base::max(n - 3.0F, base::broadcast(1.0F)), base::broadcast(kMinNoise));
    const base::Floats noise_energy = n * (kGradientNoise * noise);
    const base::Floats information = all - noise_energy;
    const base::Floats known = base::max(information, base::broadcast(1.0F));
    const base::Floats step = -slope / known;
    const base::Floats chance = base::square_root(2.0F * kCorrelatedNoise * inverse);
    const base::Floats min_information =
        noise_energy * base::max(base::broadcast(kMinTexture), kMinSignificance * chance);
    const base::Masks good =
        (n >= min_num_pixels) & (all > 0.05F * c_gg) & (information > min_information);
    const base::Floats sigma = base::square_root(kCorrelatedNoise * noise / known);
    return {base::select(good & (base::abs(step) < kMaxStep_px), step),
            base::select(good, base::max(sigma, base::broadcast(1e-3F)))};
}

struct Columns {
    const std::int32_t* of[kNumTerms];
};

DIVEMESH_INLINE_BODY void step_row(const Columns& columns,
                                   int width,
                                   float* disparity,
                                   float* sigma) {
    for (int x = 0; x < width; x += base::kLanes) {
        const base::Floats d = base::load(disparity + x);
        base::store(sigma + x, base::Floats{});
        if (!base::any(d > 0.0F)) continue;
        base::Floats sums[kNumTerms];
        for (int term = 0; term < kNumTerms; ++term) {
            const std::int32_t* first = columns.of[term] + x - kWindowRadius_px;
            base::Masks sum = base::load_lanes<base::Masks>(first);
            for (int i = 1; i < kWindow_px; ++i) sum += base::load_lanes<base::Masks>(first + i);
            sums[term] = __builtin_convertvector(sum, base::Floats);
        }
        const Fit fit = fit_step(sums, kMinPixels);
        base::store(disparity + x, d + base::select(d > 0.0F, fit.step_px));
        base::store(sigma + x, base::select(d > 0.0F, fit.sigma_px));
    }
}

// Computes steps and sigmas of blocks, each from its own sums and those of the eight blocks around
// it.
void fit_blocks(
    const float* const (&sums)[kNumTerms], int stride, int num, float* step, float* sigma) {
    for (int i = 0; i < num; i += base::kLanes) {
        base::Floats wide[kNumTerms];
        for (int term = 0; term < kNumTerms; ++term) {
            wide[term] = base::Floats{};
            for (int dy = -1; dy <= 1; ++dy)
                for (int dx = -1; dx <= 1; ++dx)
                    wide[term] += base::load(sums[term] + i + std::ptrdiff_t{dy} * stride + dx);
        }
        const Fit fit = fit_step(wide, kMinWidePixels);
        const base::Floats both =
            base::square_root(fit.sigma_px * fit.sigma_px + kWideSigma_px * kWideSigma_px);
        base::store(step + i, fit.step_px);
        base::store(sigma + i, base::select(fit.sigma_px > 0.0F, both));
    }
}

// Applies the steps of the blocks where the narrow window had no result.
void step_by_block_row(
    int width, const float* steps, const float* sigmas, float* disparity, float* sigma) {
    for (int start = 0; start < width; start += base::kLanes) {
        if (!base::any((base::load(disparity + start) > 0.0F) &
                       (base::load(sigma + start) <= 0.0F)))
            continue;
        for (int x = start; x < start + base::kLanes; ++x) {
            if (disparity[x] <= 0.0F || sigma[x] > 0.0F) continue;
            disparity[x] += steps[x / kWindow_px];
            sigma[x] = sigmas[x / kWindow_px];
        }
    }
}

}  // namespace

void SubpixelRefinement::take(const cv::Mat& left,
                              const cv::Mat& right,
                              PaddedDisparity& disparity_px,
                              PaddedDisparity& sigma_px) {
    const auto step = base::compiled_for<step_row>(instructions_);
    sigma_px.resize(disparity_px.size());
    terms_.begin(left.cols);
    begin_blocks(left.size());
    const int num_block_rows = (left.rows + kWindow_px - 1) / kWindow_px;
    for (int y = 0; y < num_block_rows * kWindow_px + kWindowRadius_px; ++y) {
        if (y < left.rows)
            terms_.add_row(
                {left.ptr<std::uint8_t>(y), right.ptr<std::uint8_t>(y), disparity_px.row(y)});
        else
            terms_.add_empty_row();
        const int center = y - kWindowRadius_px;
        if (center >= 0 && center % kWindow_px == kWindowRadius_px) add_blocks(center / kWindow_px);
        if (center < 0 || center >= left.rows) continue;
        Columns columns;
        for (int term = 0; term < kNumTerms; ++term) columns.of[term] = terms_.columns(term);
        step(columns, left.cols, disparity_px.row(center), sigma_px.row(center));
    }
    step_by_blocks(disparity_px, sigma_px);
}

void SubpixelRefinement::begin_blocks(cv::Size size) {
    const int rows = (size.height + kWindow_px - 1) / kWindow_px;
    const int columns = (size.width + kWindow_px - 1) / kWindow_px;
    blocks_.stride = columns + 2 + base::kLanes;
    const auto num = static_cast<std::size_t>(rows + 2) * blocks_.stride + base::kLanes;
    for (auto& sums : blocks_.sums) sums.assign(num, 0.0F);
    blocks_.step_px.assign(num, 0.0F);
    blocks_.sigma_px.assign(num, 0.0F);
}

void SubpixelRefinement::add_blocks(int block_y) {
    const std::size_t first = static_cast<std::size_t>(block_y + 1) * blocks_.stride + 1;
    const int num = blocks_.stride - 2 - base::kLanes;
    for (int term = 0; term < kNumTerms; ++term) {
        const std::int32_t* column = terms_.columns(term);
        float* sums = blocks_.sums[term].data() + first;
        for (int i = 0; i < num; ++i, column += kWindow_px)
            sums[i] = static_cast<float>(std::accumulate(column, column + kWindow_px, 0));
    }
}

void SubpixelRefinement::step_by_blocks(PaddedDisparity& disparity_px, PaddedDisparity& sigma_px) {
    const float* sums[kNumTerms];
    for (int y = 0; y < disparity_px.height(); ++y) {
        const std::size_t first = static_cast<std::size_t>(y / kWindow_px + 1) * blocks_.stride + 1;
        float* steps = blocks_.step_px.data() + first;
        float* sigmas = blocks_.sigma_px.data() + first;
        if (y % kWindow_px == 0) {
            for (int term = 0; term < kNumTerms; ++term)
                sums[term] = blocks_.sums[term].data() + first;
            fit_blocks(sums, blocks_.stride, blocks_.stride - 2 - base::kLanes, steps, sigmas);
        }
        step_by_block_row(
            disparity_px.width(), steps, sigmas, disparity_px.row(y), sigma_px.row(y));
    }
}

}  // namespace divemesh::stereo
