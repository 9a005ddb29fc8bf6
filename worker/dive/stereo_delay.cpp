#include "worker/dive/stereo_delay.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>

#include "worker/stats/median.hpp"

namespace divemesh::dive {
namespace {

constexpr int kIterations = 12;
constexpr double kMinScale_px = 0.3;  // the noise of tracking
constexpr double kTukeyScales = 4.0;  // beyond this many scales a sample has no weight
constexpr double kFits_px = 2.0;
constexpr std::size_t kMinSamples = 100;
constexpr std::size_t kMinMoments = 4;
constexpr std::size_t kMinSamplesOfMoment = 15;
constexpr double kMinRate_px_s = 2.0;  // below this the noise of tracking decides

constexpr double kMinDelay_s = 0.002;
constexpr double kSigmas = 5.0;

using Model = Eigen::Vector4d;  // delay in s; misalignment in px: constant, by x, by y

Model regressor(const EpipolarSample& s) { return {s.rate_px_s, 1.0, s.ray.x(), s.ray.y()}; }

double residual_px(const Model& model, const EpipolarSample& s) {
    return s.error_px - model.dot(regressor(s));
}

double median_residual_px(const Model& model, const std::vector<EpipolarSample>& samples) {
    std::vector<double> residuals;
    residuals.reserve(samples.size());
    for (const EpipolarSample& s : samples) residuals.push_back(std::abs(residual_px(model, s)));
    return stats::upper_median(std::move(residuals));
}

// Tukey's biweight.
double tukey_weight(double residual, double scale) {
    const double u = residual / (kTukeyScales * scale);
    return std::abs(u) < 1.0 ? (1.0 - u * u) * (1.0 - u * u) : 0.0;
}

// Solves weighted least squares by Tukey's biweight; its scale follows the median residual.
Model fit(const std::vector<EpipolarSample>& samples) {
    Model model = Model::Zero();
    std::vector<double> errors;
    errors.reserve(samples.size());
    for (const EpipolarSample& s : samples) errors.push_back(s.error_px);
    model[1] = stats::upper_median(std::move(errors));
    for (int i = 0; i < kIterations; ++i) {
        const double scale_px = std::max(kMinScale_px, 1.5 * median_residual_px(model, samples));
        Eigen::Matrix4d H = Eigen::Matrix4d::Zero();
        Model b = Model::Zero();
        for (const EpipolarSample& s : samples) {
            const double weight = tukey_weight(residual_px(model, s), scale_px);
            const Model a = regressor(s);
            H += weight * a * a.transpose();
            b += weight * a * s.error_px;
        }
        H.diagonal() += Eigen::Vector4d(1e-3, 1e-3, 1e-1, 1e-1);  // keeps unseen terms near 0
        model = H.ldlt().solve(b);
    }
    return model;
}

// Returns the delay by one moment alone, the misalignment given. Its scale is its own, as the delay
// may differ from that of the whole.
double delay_of_moment(Model model, const std::vector<EpipolarSample>& samples) {
    for (int i = 0; i < kIterations; ++i) {
        const double scale_px = std::max(kMinScale_px, 1.5 * median_residual_px(model, samples));
        double numerator = 0.0;
        double denominator = 1e-3;
        for (const EpipolarSample& s : samples) {
            const double weight = tukey_weight(residual_px(model, s), scale_px) * s.rate_px_s;
            numerator += weight * residual_px(model, s);
            denominator += weight * s.rate_px_s;
        }
        model[0] += numerator / denominator;
    }
    return model[0];
}

template <typename Get>
double median_abs(const std::vector<EpipolarSample>& samples, const Get& get) {
    std::vector<double> values;
    values.reserve(samples.size());
    for (const EpipolarSample& s : samples) values.push_back(std::abs(get(s)));
    return stats::upper_median(std::move(values));
}

}  // namespace

bool StereoDelay::is_significant() const {
    return is_determined && std::abs(delay_s) > std::max(kMinDelay_s, kSigmas * sigma_s);
}

StereoDelay estimate_delay(const std::vector<EpipolarMoment>& moments) {
    StereoDelay result;
    std::vector<EpipolarSample> samples;
    int num_corners = 0;
    for (const EpipolarMoment& moment : moments) {
        num_corners += moment.num_corners;
        samples.insert(samples.end(), moment.samples.begin(), moment.samples.end());
    }
    if (samples.size() < kMinSamples) return result;
    const Model model = fit(samples);
    result.delay_s = model[0];
    result.spread_px = median_residual_px(model, samples);
    result.rate_px_s = median_abs(samples, [](const EpipolarSample& s) { return s.rate_px_s; });
    result.flow_px_s = median_abs(samples, [](const EpipolarSample& s) { return s.flow_px_s; });
    result.speed_m_s = median_abs(samples, [](const EpipolarSample& s) { return s.speed_m_s; });
    const auto num_fitting =
        std::count_if(samples.begin(), samples.end(), [&](const EpipolarSample& s) {
            return std::abs(residual_px(model, s)) < kFits_px;
        });
    result.share_fitting = static_cast<double>(num_fitting) / std::max(1, num_corners);
    std::vector<double> deviations_s;
    for (const EpipolarMoment& moment : moments) {
        const bool has_enough = moment.samples.size() >= kMinSamplesOfMoment;
        result.by_moment_s.push_back(has_enough ? delay_of_moment(model, moment.samples)
                                                : std::numeric_limits<double>::quiet_NaN());
        if (has_enough)
            deviations_s.push_back(std::abs(result.by_moment_s.back() - result.delay_s));
    }
    if (deviations_s.size() < kMinMoments || result.rate_px_s < kMinRate_px_s) return result;
    // 1.48 times the median deviation is the standard deviation of normal scatter.
    const auto num_moments = static_cast<double>(deviations_s.size());
    result.sigma_s = 1.48 * stats::upper_median(std::move(deviations_s)) / std::sqrt(num_moments);
    result.is_determined = true;
    return result;
}

}  // namespace divemesh::dive
