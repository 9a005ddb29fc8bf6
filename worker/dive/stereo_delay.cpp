#include "worker/dive/stereo_delay.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>

#include "worker/stats/median.hpp"
#include "worker/stats/robust.hpp"

namespace divemesh::dive {
namespace {

constexpr int kIterations = 12;
constexpr double kMinScale_px = 0.3;  // the noise of tracking
constexpr double kTukeyScales = 4.0;  // beyond this many scales a sample has no weight
constexpr double kFits_px = 2.0;
constexpr double kFitsAlone_px = 4.0;  // without rates, the motion during a delay is not taken off
// Fewer corners tell nothing: a quarter and more fit where the cameras match, ten of 50.
constexpr int kMinCorners = 50;
constexpr std::size_t kMinSamples = 100;
constexpr std::size_t kMinMoments = 4;
constexpr std::size_t kMinSamplesOfMoment = 15;
constexpr double kMinRate_px_s = 2.0;  // below this the noise of tracking decides

// A knock of the right camera between two moments: how far it moves their rows at least, and what
// it leaves of the loss at most.
constexpr double kMinKnock_px = 0.5;
constexpr double kMaxLossRatio = 0.5;
constexpr std::size_t kMinMomentsOfSide = 2;

constexpr double kMinDelay_s = 0.002;
constexpr double kSigmas = 5.0;
// Rates are means over the time to the later image, not over the delay: relative, by rendered
// dives.
constexpr double kRateError = 0.05;
// The part of a misalignment that the three terms do not describe: the baseline's direction,
// lenses.
constexpr double kMisalignmentError = 0.003;

using Model = Eigen::Vector4d;  // delay in s; misalignment in px: pitch, roll, vertical scale

const Model kPriorInformation(1e-3, 1e-3, 1e-1, 1e-1);  // keeps unseen terms near 0

// Returns the derivatives of the error, which is an angle. The right camera turns about itself, so
// a roll moves what is near by less than what is far at the same place in the left image.
Model regressor(const EpipolarSample& s) {
    const Eigen::Vector2d& ray = s.right_ray;
    const double from_baseline = std::hypot(1.0, ray.y());  // of the plane, at z = 1
    const double length = std::hypot(1.0, ray.x(), ray.y());
    return {s.rate_px_s,
            from_baseline / length,
            ray.x() / (from_baseline * length),
            ray.y() / (from_baseline * length)};
}

double residual_px(const Model& model, const EpipolarSample& s) {
    return s.error_px - model.dot(regressor(s));
}

double median_residual_px(const Model& model, const std::vector<EpipolarSample>& samples) {
    std::vector<double> residuals;
    residuals.reserve(samples.size());
    for (const EpipolarSample& s : samples) residuals.push_back(std::abs(residual_px(model, s)));
    return stats::upper_median(std::move(residuals));
}

// Returns the mean of Tukey's loss, with a scale that does not depend on the fit.
double mean_loss_px2(const Model& model, const std::vector<EpipolarSample>& samples) {
    double sum = 0.0;
    for (const EpipolarSample& s : samples)
        sum += stats::tukey_loss(residual_px(model, s), kFits_px);
    return sum / static_cast<double>(samples.size());
}

struct Fit {
    Model model = Model::Zero();
    double last_step_s = 0.0;  // of the delay
};

// Solves weighted least squares by Tukey's biweight; its scale follows the median residual.
Fit fit(const std::vector<EpipolarSample>& samples) {
    double last_step_s = 0.0;
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
            const double weight =
                stats::tukey_weight(residual_px(model, s), kTukeyScales * scale_px);
            const Model a = regressor(s);
            H += weight * a * a.transpose();
            b += weight * a * s.error_px;
        }
        H.diagonal() += kPriorInformation;
        const Model next = H.ldlt().solve(b);
        last_step_s = std::abs(next[0] - model[0]);
        model = next;
    }
    return {model, last_step_s};
}

// Returns the standard deviation of the delay from the scatter between moments: errors within a
// moment are not independent (cluster-robust covariance, Liang and Zeger 1986). It contains what
// the misalignment, which is estimated with the delay, is not known by.
double sigma_between_moments(const Model& model, const std::vector<EpipolarMoment>& moments) {
    std::vector<EpipolarSample> samples;
    for (const EpipolarMoment& moment : moments)
        samples.insert(samples.end(), moment.samples.begin(), moment.samples.end());
    const double limit_px =
        kTukeyScales * std::max(kMinScale_px, 1.5 * median_residual_px(model, samples));
    Eigen::Matrix4d H = kPriorInformation.asDiagonal();
    Eigen::Matrix4d scatter = Eigen::Matrix4d::Zero();
    double num_moments = 0.0;
    for (const EpipolarMoment& moment : moments) {
        if (moment.samples.empty()) continue;
        Model gradient = Model::Zero();
        for (const EpipolarSample& s : moment.samples) {
            const double residual = residual_px(model, s);
            const double weight = stats::tukey_weight(residual, limit_px);
            const Model a = regressor(s);
            H += weight * a * a.transpose();
            gradient += weight * residual * a;
        }
        scatter += gradient * gradient.transpose();
        num_moments += 1.0;
    }
    const Model by_gradient = H.ldlt().solve(Model::Unit(0));
    return std::sqrt(by_gradient.dot(scatter * by_gradient) * num_moments / (num_moments - 1.0));
}

// Returns the delay by one moment alone, the misalignment given. Its scale is its own, as the delay
// may differ from that of the whole.
double delay_of_moment(Model model, const std::vector<EpipolarSample>& samples) {
    for (int i = 0; i < kIterations; ++i) {
        const double scale_px = std::max(kMinScale_px, 1.5 * median_residual_px(model, samples));
        double numerator = 0.0;
        double denominator = 1e-3;
        for (const EpipolarSample& s : samples) {
            const double weight =
                stats::tukey_weight(residual_px(model, s), kTukeyScales * scale_px) * s.rate_px_s;
            numerator += weight * residual_px(model, s);
            denominator += weight * s.rate_px_s;
        }
        model[0] += numerator / denominator;
    }
    return model[0];
}

// Returns the RMS of what the misalignment moves the samples by.
double misalignment_rms_px(const Model& model, const std::vector<EpipolarSample>& samples) {
    double squares = 0.0;
    for (const EpipolarSample& s : samples)
        squares += std::pow(model.tail<3>().dot(regressor(s).tail<3>()), 2);
    return std::sqrt(squares / static_cast<double>(samples.size()));
}

std::int64_t count_fitting(const Model& model,
                           const std::vector<EpipolarSample>& samples,
                           double tolerance_px) {
    return std::count_if(samples.begin(), samples.end(), [&](const EpipolarSample& s) {
        return std::abs(residual_px(model, s)) < tolerance_px;
    });
}

// Returns the share of the corners that fit the geometry of their pair, whatever moves. A corner
// that is tracked into an image of another time or scene lies behind the cameras as often as in
// front of them, and anywhere across its line: for two that do not fit, at most one fits by chance.
double share_fitting_alone(const std::vector<EpipolarMoment>& moments, int num_corners) {
    std::vector<EpipolarSample> samples;
    std::int64_t num_unfit = 0;
    for (const EpipolarMoment& moment : moments) {
        samples.insert(samples.end(), moment.samples.begin(), moment.samples.end());
        samples.insert(samples.end(), moment.without_rate.begin(), moment.without_rate.end());
        num_unfit += moment.num_mismatches;
    }
    for (EpipolarSample& s : samples) s.rate_px_s = 0.0;
    const std::int64_t num_fitting = count_fitting(fit(samples).model, samples, kFitsAlone_px);
    num_unfit += std::ssize(samples) - num_fitting;
    const double num_beyond_chance =
        static_cast<double>(num_fitting) - 0.5 * static_cast<double>(num_unfit);
    return std::max(0.0, num_beyond_chance) / num_corners;
}

template <typename Get>
double median_abs(const std::vector<EpipolarSample>& samples, const Get& get) {
    std::vector<double> values;
    values.reserve(samples.size());
    for (const EpipolarSample& s : samples) values.push_back(std::abs(get(s)));
    return stats::upper_median(std::move(values));
}

using Moments = std::vector<EpipolarMoment>;

std::vector<EpipolarSample> samples_of(Moments::const_iterator begin, Moments::const_iterator end) {
    std::vector<EpipolarSample> samples;
    for (auto moment = begin; moment != end; ++moment)
        samples.insert(samples.end(), moment->samples.begin(), moment->samples.end());
    return samples;
}

double mean_loss_px2(const Moments& moments) {
    const std::vector<EpipolarSample> samples = samples_of(moments.begin(), moments.end());
    return mean_loss_px2(fit(samples).model, samples);
}

// Returns the moments as if the right camera had stayed where it was at the first of them, if
// something knocked it in between: one delay and one misalignment would explain that by a delay.
Moments without_knock(const Moments& moments) {
    if (samples_of(moments.begin(), moments.end()).size() < 2 * kMinSamples) return moments;
    Moments best = moments;
    double best_px2 = kMaxLossRatio * mean_loss_px2(moments);
    for (std::size_t k = kMinMomentsOfSide; k + kMinMomentsOfSide <= moments.size(); ++k) {
        const auto knock = moments.begin() + static_cast<std::ptrdiff_t>(k);
        const std::vector<EpipolarSample> before = samples_of(moments.begin(), knock);
        const std::vector<EpipolarSample> after = samples_of(knock, moments.end());
        if (std::min(before.size(), after.size()) < kMinSamples) continue;
        Model change = fit(after).model - fit(before).model;
        change[0] = 0.0;
        if (misalignment_rms_px(change, after) < kMinKnock_px) continue;
        Moments still = moments;
        for (std::size_t i = k; i < still.size(); ++i)
            for (auto* samples : {&still[i].samples, &still[i].without_rate})
                for (EpipolarSample& s : *samples) s.error_px -= change.dot(regressor(s));
        const double loss_px2 = mean_loss_px2(still);
        if (loss_px2 >= best_px2) continue;
        best_px2 = loss_px2;
        best = std::move(still);
    }
    return best;
}

}  // namespace

bool StereoDelay::is_significant() const {
    return is_determined && std::abs(delay_s) > std::max(kMinDelay_s, kSigmas * sigma_s);
}

std::vector<EpipolarMoment> without_gaps(std::vector<EpipolarMoment> moments,
                                         const std::vector<double>& gaps_s) {
    for (std::size_t k = 0; k < moments.size(); ++k)
        for (EpipolarSample& s : moments[k].samples) s.error_px -= gaps_s[k] * s.rate_px_s;
    return moments;
}

StereoDelay estimate_delay(const Moments& recorded) {
    StereoDelay result;
    const Moments moments = without_knock(recorded);
    const std::vector<EpipolarSample> samples = samples_of(moments.begin(), moments.end());
    int num_corners = 0;
    for (const EpipolarMoment& moment : moments) num_corners += moment.num_corners;
    if (num_corners >= kMinCorners)
        result.share_fitting = share_fitting_alone(moments, num_corners);
    if (samples.size() < kMinSamples) return result;
    const Fit fitted = fit(samples);
    const Model& model = fitted.model;
    result.delay_s = model[0];
    result.spread_px = median_residual_px(model, samples);
    result.loss_px2 = mean_loss_px2(model, samples);
    result.rate_px_s = median_abs(samples, [](const EpipolarSample& s) { return s.rate_px_s; });
    result.flow_px_s = median_abs(samples, [](const EpipolarSample& s) { return s.flow_px_s; });
    result.speed_m_s = median_abs(samples, [](const EpipolarSample& s) { return s.speed_m_s; });
    const auto num_fitting = static_cast<double>(count_fitting(model, samples, kFits_px));
    result.share_fitting =
        std::max(result.share_fitting.value_or(0.0), num_fitting / std::max(1, num_corners));
    std::size_t num_moments = 0;
    for (const EpipolarMoment& moment : moments) {
        const bool has_enough = moment.samples.size() >= kMinSamplesOfMoment;
        result.by_moment_s.push_back(has_enough ? delay_of_moment(model, moment.samples)
                                                : std::numeric_limits<double>::quiet_NaN());
        if (has_enough) ++num_moments;
    }
    if (num_moments < kMinMoments || result.rate_px_s < kMinRate_px_s) return result;
    result.sigma_s =
        std::hypot(sigma_between_moments(model, moments),
                   kRateError * result.delay_s,
                   kMisalignmentError * misalignment_rms_px(model, samples) / result.rate_px_s);
    result.is_determined = fitted.last_step_s < result.sigma_s;
    return result;
}

}  // namespace divemesh::dive
