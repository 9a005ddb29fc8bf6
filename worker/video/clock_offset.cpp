#include "worker/video/clock_offset.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <vector>

#include "worker/base/seconds.hpp"
#include "worker/stats/median.hpp"

namespace divemesh::video {
namespace {

constexpr std::size_t kCoarseBins = 80;  // 20 ms: a drift of 20 minutes stays within a few
constexpr double kMinSound_s = 4.0;      // that both have
constexpr double kWindow_s = 10.0;
constexpr double kMinWindow_s = 1.0;
constexpr int kMaxWindows = 40;
constexpr int kMinWindows = 3;
constexpr double kSearched_s = 0.15;  // around the coarse offset: drift and coarse bins
constexpr double kMinPeak = 7.0;      // standard deviations of the correlation elsewhere
constexpr double kAgree_s = 0.002;    // windows that agree, from one line
constexpr double kMinAgreeing = 0.5;  // of the windows
constexpr double kDriftAfter_s = 120.0;
constexpr double kMaxDrift = 5e-4;  // a crystal is ten times as good
constexpr double kDriftSigmas = 3.0;
constexpr double kBinError_s = 0.3 * SoundEnvelope::kBin_s;  // 1 / sqrt(12)

struct Peak {
    double lag = 0.0;     // in bins: place in `right` minus place in `left`
    double height = 0.0;  // in standard deviations of the correlation
};

// Returns values about their mean.
cv::Mat centred(const float* values, std::size_t num, int size) {
    cv::Mat padded = cv::Mat::zeros(1, size, CV_32F);
    const cv::Mat given(1, static_cast<int>(num), CV_32F, const_cast<float*>(values));
    const double mean = cv::mean(given)[0];
    for (int i = 0; i < given.cols; ++i)
        padded.at<float>(i) = static_cast<float>(given.at<float>(i) - mean);
    return padded;
}

// Gives each frequency the same weight: its phase alone counts.
void whiten(cv::Mat& spectrum) {
    double mean = 0.0;
    for (int i = 0; i < spectrum.cols; ++i)
        mean += cv::norm(spectrum.at<cv::Vec2f>(i)) / spectrum.cols;
    for (int i = 0; i < spectrum.cols; ++i) {
        cv::Vec2f& value = spectrum.at<cv::Vec2f>(i);
        const double size = cv::norm(value);
        // Leaves out values below a thousandth of the mean, which are rounding alone.
        value = size > 1e-3 * mean ? value * (1.0 / size) : cv::Vec2f(0.0F, 0.0F);
    }
}

// Correlates two stretches and returns the highest peak whose lag is within limits.
Peak correlate(const cv::Mat& left, const cv::Mat& right, int min_lag, int max_lag) {
    cv::Mat left_spectrum;
    cv::Mat right_spectrum;
    cv::Mat product;
    cv::Mat correlation;
    cv::dft(left, left_spectrum, cv::DFT_COMPLEX_OUTPUT);
    cv::dft(right, right_spectrum, cv::DFT_COMPLEX_OUTPUT);
    cv::mulSpectrums(right_spectrum, left_spectrum, product, 0, true);
    whiten(product);
    cv::dft(product, correlation, cv::DFT_INVERSE | cv::DFT_REAL_OUTPUT | cv::DFT_SCALE);
    const int size = correlation.cols;
    const auto at = [&](int lag) { return correlation.at<float>((lag % size + size) % size); };
    int best = min_lag;
    for (int lag = min_lag; lag <= max_lag; ++lag)
        if (at(lag) > at(best)) best = lag;
    const double rms = cv::norm(correlation) / std::sqrt(static_cast<double>(size));
    const double before = at(best - 1);
    const double after = at(best + 1);
    const double curvature = before - 2.0 * at(best) + after;
    const double shift = curvature < 0.0 ? 0.5 * (before - after) / curvature : 0.0;
    return {best + std::clamp(shift, -0.5, 0.5), rms > 0.0 ? at(best) / rms : 0.0};
}

// Returns the logarithm of loudness in coarse bins, in which breaths count as much as knocks.
std::vector<float> coarse(const SoundEnvelope& sound) {
    std::vector<float> bins;
    bins.reserve(sound.loudness.size() / kCoarseBins);
    for (std::size_t at = 0; at + kCoarseBins <= sound.loudness.size(); at += kCoarseBins) {
        float sum = 1e-6F;
        for (std::size_t i = at; i < at + kCoarseBins; ++i) sum += sound.loudness[i];
        bins.push_back(std::log(sum));
    }
    return bins;
}

// Returns the offset to the coarse bin.
std::optional<double> coarse_offset_s(const SoundEnvelope& left, const SoundEnvelope& right) {
    const auto a = coarse(left);
    const auto b = coarse(right);
    const double bin_s = kCoarseBins * SoundEnvelope::kBin_s;
    const int overlap = static_cast<int>(kMinSound_s / bin_s);
    if (static_cast<int>(std::min(a.size(), b.size())) <= overlap) return std::nullopt;
    const int size = cv::getOptimalDFTSize(static_cast<int>(a.size() + b.size()));
    const Peak peak = correlate(centred(a.data(), a.size(), size),
                                centred(b.data(), b.size(), size),
                                overlap - static_cast<int>(a.size()),
                                static_cast<int>(b.size()) - overlap);
    if (peak.height < kMinPeak) return std::nullopt;
    return left.start_s - right.start_s - peak.lag * bin_s;
}

// The offset by a window of the right sound.
struct WindowOffset {
    double right_s = 0.0;
    double offset_s = 0.0;
};

std::optional<WindowOffset> offset_of_window(const SoundEnvelope& left,
                                             const SoundEnvelope& right,
                                             double right_s,
                                             double window_s,
                                             double coarse_s) {
    constexpr double kBin_s = SoundEnvelope::kBin_s;
    const auto num = static_cast<std::int64_t>(window_s / kBin_s);
    const auto at_right = std::llround((right_s - right.start_s) / kBin_s);
    const auto at_left = std::llround((right_s + coarse_s - left.start_s) / kBin_s);
    if (at_right < 0 || at_left < 0 || at_right + num > std::ssize(right.loudness) ||
        at_left + num > std::ssize(left.loudness))
        return std::nullopt;
    const int size = cv::getOptimalDFTSize(static_cast<int>(2 * num));
    const int searched = static_cast<int>(kSearched_s / kBin_s);
    const auto count = static_cast<std::size_t>(num);
    const Peak peak =
        correlate(centred(&left.loudness[static_cast<std::size_t>(at_left)], count, size),
                  centred(&right.loudness[static_cast<std::size_t>(at_right)], count, size),
                  -searched,
                  searched);
    if (peak.height < kMinPeak) return std::nullopt;
    const double left_s = left.start_s + kBin_s * static_cast<double>(at_left);
    const double heard_s = right.start_s + kBin_s * (static_cast<double>(at_right) + peak.lag);
    return WindowOffset{right_s, left_s - heard_s};
}

// Returns the offset of each window that has a clear one.
std::vector<WindowOffset> offsets_of_windows(const SoundEnvelope& left,
                                             const SoundEnvelope& right,
                                             double coarse_s,
                                             int& num_windows) {
    const double begin_s = std::max(right.start_s, left.start_s - coarse_s);
    const double end_s = std::min(right.end_s(), left.end_s() - coarse_s);
    const double window_s = std::clamp((end_s - begin_s) / 4.0, kMinWindow_s, kWindow_s);
    const double span_s = end_s - begin_s - window_s;
    num_windows = std::clamp(static_cast<int>((end_s - begin_s) / window_s), 1, kMaxWindows);
    std::vector<WindowOffset> offsets;
    for (int i = 0; i < num_windows; ++i) {
        const double right_s = begin_s + span_s * (i + 0.5) / num_windows;
        if (const auto offset = offset_of_window(left, right, right_s, window_s, coarse_s))
            offsets.push_back(*offset);
    }
    return offsets;
}

// Returns the median slope between pairs of windows (Theil and Sen).
double drift_of(const std::vector<WindowOffset>& offsets) {
    const double span_s = offsets.back().right_s - offsets.front().right_s;
    if (span_s < kDriftAfter_s) return 0.0;
    std::vector<double> slopes;
    for (const WindowOffset& a : offsets)
        for (const WindowOffset& b : offsets)
            if (b.right_s - a.right_s > 0.25 * span_s)
                slopes.push_back((b.offset_s - a.offset_s) / (b.right_s - a.right_s));
    const double drift = stats::median(std::move(slopes));
    return std::abs(drift) < kMaxDrift ? drift : 0.0;
}

std::vector<double> residuals_s(const std::vector<WindowOffset>& offsets,
                                const ClockOffset& clock) {
    std::vector<double> residuals;
    residuals.reserve(offsets.size());
    for (const WindowOffset& offset : offsets)
        residuals.push_back(offset.offset_s - clock.offset_s - clock.drift * offset.right_s);
    return residuals;
}

// Returns the line with a slope through the middle of the offsets.
ClockOffset line_through(const std::vector<WindowOffset>& offsets, double drift) {
    ClockOffset clock{0.0, drift, 0.0};
    clock.offset_s = stats::median(residuals_s(offsets, clock));
    return clock;
}

// Returns the standard deviation of windows about their line, robustly.
double scatter_s(const std::vector<WindowOffset>& offsets, const ClockOffset& clock) {
    auto residuals = residuals_s(offsets, clock);
    for (double& residual : residuals) residual = std::abs(residual);
    return std::hypot(1.4826 * stats::median(std::move(residuals)), kBinError_s);
}

}  // namespace

std::int64_t ClockOffset::left_ns(std::int64_t right_ns) const {
    return right_ns + base::to_ns(offset_s + drift * base::to_s(right_ns));
}

std::optional<ClockOffset> offset_by_sound(const SoundEnvelope& left, const SoundEnvelope& right) {
    const auto coarse_s = coarse_offset_s(left, right);
    if (!coarse_s) return std::nullopt;
    int num_windows = 0;
    const auto offsets = offsets_of_windows(left, right, *coarse_s, num_windows);
    if (static_cast<int>(offsets.size()) < kMinWindows) return std::nullopt;
    const double num = static_cast<double>(offsets.size());
    const double drift = drift_of(offsets);
    ClockOffset clock = line_through(offsets, drift);
    const double span_s = offsets.back().right_s - offsets.front().right_s;
    if (std::abs(drift) * span_s < kDriftSigmas * scatter_s(offsets, clock) * 3.5 / std::sqrt(num))
        clock = line_through(offsets, 0.0);
    std::int64_t num_agreeing = 0;
    for (const double residual : residuals_s(offsets, clock))
        if (std::abs(residual) < kAgree_s) ++num_agreeing;
    if (static_cast<double>(num_agreeing) <
        std::max<double>(kMinWindows, kMinAgreeing * num_windows))
        return std::nullopt;
    clock.sigma_s = scatter_s(offsets, clock) / std::sqrt(num);
    return clock;
}

}  // namespace divemesh::video
