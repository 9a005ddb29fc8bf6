#include "worker/imu/judge_gyroscope.hpp"

#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "worker/base/angle.hpp"
#include "worker/base/rotation_vector.hpp"
#include "worker/base/seconds.hpp"
#include "worker/imu/gyroscope_path.hpp"
#include "worker/stats/median.hpp"

namespace divemesh::imu {
namespace {

constexpr std::int64_t kMinSpan_ns = 300'000'000;
constexpr std::size_t kMinSpans = 16;  // five seconds
constexpr std::size_t kMaxSpans = 40;  // what is wrong for twelve seconds is found then
// A far offset has a hundred chances to fit by accident, so it needs ten seconds.
constexpr std::size_t kMinSpansToShift = 32;
constexpr double kMinCovered = 0.6;  // share of the spans that samples cover
constexpr std::size_t kMinSpansToTellBias = 8;
// Over longer spans units that are wrong turn by more than half a turn, which no rotation shows.
constexpr std::int64_t kMaxSpanToTellBias_ns = 600'000'000;
// Data sheets of the cheapest gyroscopes allow 0.35 rad/s.
constexpr double kMaxBias_rad_s = 0.5;
constexpr double kStep_s = 0.02;
constexpr double kFineStep_s = 0.002;    // around the best far offset
constexpr double kMaxBeyond_s = 0.1;     // searched beyond the near offsets at first
constexpr double kMinRate_rad_s = 0.02;  // RMS; below this noise dominates
constexpr double kNoise_rad_s = 0.008;   // of vision over a span, at worst
constexpr double kFits = 0.1;            // unexplained shares
constexpr double kContradicts = 0.25;
// Max share that another offset leaves unexplained, relative to the best near one.
constexpr double kMaxUnexplainedRatio = 0.4;
// Rates that are wrong by more than the cheapest gyroscope's scale; less is estimated with the
// dive.
constexpr double kMaxScaleError = 0.12;
constexpr double kMinScaledRate_rad_s = 3.0 * kMinRate_rad_s;  // noise adds less to the scale then
constexpr double kScaledShare = 0.25;  // of the residual share, that a scale leaves
constexpr double kMaxTilt_rad = 20.0 * base::kRadPerDeg;
constexpr double kRotationPrior = 0.05;  // of the correlation: holds axes without rotation
constexpr double kHuber = 3.0;           // in medians of the residuals' norms
constexpr int kNumReweightings = 3;
constexpr double kWrongRate_rad_s = 4.0 * kNoise_rad_s;

// The rates of both at one time offset.
struct Rates {
    std::vector<Eigen::Vector3d> vision;
    std::vector<Eigen::Vector3d> gyroscope;
};

std::optional<Rates> rates_at(const GyroscopePath& path,
                              const std::vector<RotationSpan>& spans,
                              double offset_s) {
    const std::int64_t shift_ns = base::to_ns(offset_s);
    Rates rates;
    for (const RotationSpan& span : spans) {
        const std::int64_t from_ns = span.from_ns + shift_ns;
        const std::int64_t to_ns = span.to_ns + shift_ns;
        if (!path.covers(from_ns, to_ns)) continue;
        rates.vision.push_back(span.rate_body);
        rates.gyroscope.push_back(path.rotation(from_ns, to_ns) / base::to_s(to_ns - from_ns));
    }
    const auto num_covered = static_cast<double>(rates.vision.size());
    if (num_covered < static_cast<double>(kMinSpans) ||
        num_covered < kMinCovered * static_cast<double>(spans.size()))
        return std::nullopt;
    return rates;
}

// Weighted second moments of both rates about their means; rad^2/s^2.
struct Moments {
    Eigen::Matrix3d gyroscope_vision = Eigen::Matrix3d::Zero();
    Eigen::Matrix3d gyroscope = Eigen::Matrix3d::Zero();
    Eigen::Matrix3d vision = Eigen::Matrix3d::Zero();
    Eigen::Vector3d mean_gyroscope = Eigen::Vector3d::Zero();
    Eigen::Vector3d mean_vision = Eigen::Vector3d::Zero();
};

Moments moments_of(const Rates& rates, const std::vector<double>& weights) {
    Moments moments;
    double sum = 0.0;
    for (std::size_t i = 0; i < weights.size(); ++i) {
        moments.mean_gyroscope += weights[i] * rates.gyroscope[i];
        moments.mean_vision += weights[i] * rates.vision[i];
        sum += weights[i];
    }
    moments.mean_gyroscope /= sum;
    moments.mean_vision /= sum;
    for (std::size_t i = 0; i < weights.size(); ++i) {
        const Eigen::Vector3d g = rates.gyroscope[i] - moments.mean_gyroscope;
        const Eigen::Vector3d v = rates.vision[i] - moments.mean_vision;
        moments.gyroscope_vision += weights[i] / sum * g * v.transpose();
        moments.gyroscope += weights[i] / sum * g * g.transpose();
        moments.vision += weights[i] / sum * v * v.transpose();
    }
    return moments;
}

// Returns the rotation that maps the gyroscope's rates to those of vision, near `given`.
Eigen::Matrix3d nearby_rotation(const Moments& moments, const Eigen::Matrix3d& given) {
    const double size = std::sqrt(moments.gyroscope.trace() * moments.vision.trace());
    const Eigen::Matrix3d correlation =
        given * moments.gyroscope_vision + kRotationPrior * size * Eigen::Matrix3d::Identity();
    const Eigen::JacobiSVD<Eigen::Matrix3d> svd(correlation,
                                                Eigen::ComputeFullU | Eigen::ComputeFullV);
    Eigen::Matrix3d signs = Eigen::Matrix3d::Identity();
    signs(2, 2) = svd.matrixU().determinant() * svd.matrixV().determinant() < 0.0 ? -1.0 : 1.0;
    const Eigen::AngleAxisd tilt(
        Eigen::Matrix3d(svd.matrixV() * signs * svd.matrixU().transpose()));
    return Eigen::AngleAxisd(std::min(tilt.angle(), kMaxTilt_rad), tilt.axis()) * given;
}

// How well the gyroscope fits vision under one mounting.
struct Fit {
    double offset_s = 0.0;
    double unexplained = 1.0;     // share, of the worst axis
    double residual_share = 1.0;  // of all axes, noise included: tells the better of two good fits
    double scale = 1.0;
    double scaled_share = 1.0;  // the residual share once that scale is taken off
    double rate_rad_s = 0.0;    // RMS about the axis with the most, of the larger of the two
    Eigen::Matrix3d mounting = Eigen::Matrix3d::Identity();
};

double unexplained_share(const Moments& moments, const Eigen::Matrix3d& mounting) {
    const Eigen::Vector3d cross = (mounting * moments.gyroscope_vision).diagonal();
    const Eigen::Vector3d gyroscope =
        (mounting * moments.gyroscope * mounting.transpose()).diagonal();
    const Eigen::Vector3d vision = moments.vision.diagonal();
    constexpr double kNoise_rad2_s2 = kNoise_rad_s * kNoise_rad_s;
    double worst = 0.0;
    for (int axis = 0; axis < 3; ++axis) {
        const double motion = std::max(gyroscope[axis], vision[axis]);
        if (motion < kMinRate_rad_s * kMinRate_rad_s) continue;
        const double residual = gyroscope[axis] + vision[axis] - 2.0 * cross[axis];
        worst = std::max(worst, (residual - kNoise_rad2_s2) / motion);
    }
    return worst;
}

// Returns the weights that make spans that do not fit count less.
std::vector<double> huber_weights(const Rates& rates,
                                  const Moments& moments,
                                  const Eigen::Matrix3d& mounting) {
    std::vector<double> norms;
    for (std::size_t i = 0; i < rates.vision.size(); ++i)
        norms.push_back((rates.vision[i] - moments.mean_vision -
                         mounting * (rates.gyroscope[i] - moments.mean_gyroscope))
                            .norm());
    const double limit = kHuber * std::max(stats::upper_median(norms), 1e-6);
    for (double& norm : norms) norm = norm > limit ? limit / norm : 1.0;
    return norms;
}

Fit fit_at(const Rates& rates, double offset_s, const Eigen::Matrix3d& given) {
    std::vector<double> weights(rates.vision.size(), 1.0);
    Moments moments;
    Eigen::Matrix3d mounting = given;
    for (int i = 0; i < kNumReweightings; ++i) {
        moments = moments_of(rates, weights);
        mounting = nearby_rotation(moments, given);
        weights = huber_weights(rates, moments, mounting);
    }
    Fit fit;
    fit.offset_s = offset_s;
    fit.mounting = mounting;
    fit.unexplained = unexplained_share(moments, mounting);
    fit.rate_rad_s = std::sqrt(
        std::max((mounting * moments.gyroscope * mounting.transpose()).diagonal().maxCoeff(),
                 moments.vision.diagonal().maxCoeff()));
    const double both = (mounting * moments.gyroscope_vision).trace();
    fit.scale = moments.gyroscope.trace() / std::max(both, 1e-12);
    fit.scaled_share =
        1.0 - both * both / std::max(moments.gyroscope.trace() * moments.vision.trace(), 1e-12);
    fit.residual_share = (moments.gyroscope.trace() + moments.vision.trace() - 2.0 * both) /
                         std::max({moments.gyroscope.trace(), moments.vision.trace(), 1e-12});
    return fit;
}

// A series of time offsets.
struct Offsets {
    double middle_s = 0.0;
    double reach_s = kNearOffset_s;
    double step_s = kStep_s;
};

// Returns the best fit among the offsets; nullopt if samples cover too few spans.
std::optional<Fit> best_fit(const GyroscopePath& path,
                            const std::vector<RotationSpan>& spans,
                            const Offsets& offsets,
                            const Eigen::Matrix3d& mounting) {
    std::optional<Fit> best;
    const int num_steps = static_cast<int>(std::lround(offsets.reach_s / offsets.step_s));
    for (int step = -num_steps; step <= num_steps; ++step) {
        const double offset_s = offsets.middle_s + offsets.step_s * step;
        const auto rates = rates_at(path, spans, offset_s);
        if (!rates) continue;
        const Fit fit = fit_at(*rates, offset_s, mounting);
        if (!best || fit.residual_share < best->residual_share) best = fit;
    }
    return best;
}

constexpr std::array<const char*, 3> kAxisNames = {"x", "y", "z"};

// Returns the axes of which `picked` is true: "x and z".
template <typename Picked>
std::string axes_where(const Picked& picked) {
    std::string names;
    for (int axis = 0; axis < 3; ++axis)
        if (picked(axis))
            names += (names.empty() ? "" : " and ") +
                     std::string(kAxisNames[static_cast<std::size_t>(axis)]);
    return names;
}

// Calls visit(mounting) for the 48 ways in which axes can be exchanged and mirrored.
template <typename Visit>
void for_each_mounting(const Visit& visit) {
    std::array<int, 3> order = {0, 1, 2};
    do {
        for (unsigned signs = 0; signs < 8; ++signs) {
            Eigen::Matrix3d mounting = Eigen::Matrix3d::Zero();
            for (int row = 0; row < 3; ++row)
                mounting(row, order[static_cast<std::size_t>(row)]) =
                    ((signs >> static_cast<unsigned>(row)) & 1U) != 0U ? -1.0 : 1.0;
            visit(mounting);
        }
    } while (std::next_permutation(order.begin(), order.end()));
}

void name_mounting(const Eigen::Matrix3d& mounting, GyroscopeJudgement& judgement) {
    const bool mirrored = mounting.determinant() < 0.0;
    judgement.fault = mirrored ? GyroscopeFault::Mirrored : GyroscopeFault::Rotated;
    judgement.axes = axes_where([&](int axis) { return mounting(axis, axis) != 1.0; });
}

// Finds what explains the contradiction: other axes, or another scale.
void explain(const GyroscopePath& path,
             const std::vector<RotationSpan>& spans,
             const Fit& near,
             GyroscopeJudgement& judgement) {
    judgement.fault = GyroscopeFault::Unexplained;
    double min_unexplained = kFits;
    for_each_mounting([&](const Eigen::Matrix3d& mounting) {
        const auto fit = best_fit(path, spans, {}, mounting);
        if (!fit || fit->unexplained >= min_unexplained) return;
        min_unexplained = fit->unexplained;
        name_mounting(mounting, judgement);
    });
    if (judgement.fault != GyroscopeFault::Unexplained) return;
    const auto scaled =
        best_fit(path, spans, {}, Eigen::Matrix3d(Eigen::Matrix3d::Identity() / near.scale));
    if (!scaled || scaled->unexplained >= kFits) return;
    judgement.fault = GyroscopeFault::Scaled;
    judgement.scale = near.scale;
}

// Returns by how much the gyroscope turns faster than the images, if in no span that is less than a
// gyroscope's bias can be. Other axes and another clock do not change how fast it turns.
std::optional<double> impossible_bias_rad_s(const GyroscopePath& path,
                                            const std::vector<RotationSpan>& spans) {
    double smallest_rad_s = std::numeric_limits<double>::infinity();
    std::size_t num = 0;
    for (const RotationSpan& span : spans) {
        const bool is_one_turn = span.to_ns - span.from_ns <= kMaxSpanToTellBias_ns;
        if (!is_one_turn || !path.covers(span.from_ns, span.to_ns)) continue;
        const double rate_rad_s =
            path.rotation(span.from_ns, span.to_ns).norm() / base::to_s(span.to_ns - span.from_ns);
        smallest_rad_s = std::min(smallest_rad_s, std::abs(rate_rad_s - span.rate_body.norm()));
        ++num;
    }
    if (num < kMinSpansToTellBias || smallest_rad_s <= kMaxBias_rad_s) return std::nullopt;
    return smallest_rad_s;
}

bool is_at_edge(const Fit& near) { return std::abs(near.offset_s) > kNearOffset_s - 0.5 * kStep_s; }

// Returns the best fit beyond the end of the near offsets at which the best near one lies. Returns
// nullopt if it lies at the end of what is searched, or is not clearly better than no offset: of a
// rig that turns slowly, every offset fits.
std::optional<Fit> fit_beyond(const GyroscopePath& path,
                              const std::vector<RotationSpan>& spans,
                              const Fit& near) {
    const Eigen::Matrix3d as_mounted = Eigen::Matrix3d::Identity();
    const auto coarse = best_fit(path, spans, {near.offset_s, kMaxBeyond_s, kStep_s}, as_mounted);
    if (!coarse || std::abs(coarse->offset_s - near.offset_s) > kMaxBeyond_s - 0.5 * kStep_s)
        return std::nullopt;
    auto fine = best_fit(path, spans, {coarse->offset_s, kStep_s, kFineStep_s}, as_mounted);
    const auto unshifted = best_fit(path, spans, {0.0, 0.0, kStep_s}, as_mounted);
    const bool is_clear = fine && unshifted && std::abs(fine->offset_s) > kNearOffset_s &&
                          fine->unexplained < kFits &&
                          fine->residual_share < kMaxUnexplainedRatio * unshifted->residual_share;
    return is_clear ? fine : std::nullopt;
}

// Returns the best fit among all offsets. Returns nullopt if it lies at an end of them, because the
// minimum may lie beyond.
std::optional<Fit> far_fit(const GyroscopePath& path, const std::vector<RotationSpan>& spans) {
    const Eigen::Matrix3d as_mounted = Eigen::Matrix3d::Identity();
    const auto coarse = best_fit(path, spans, {0.0, kMaxOffset_s, kStep_s}, as_mounted);
    if (!coarse) return std::nullopt;
    auto fine = best_fit(path, spans, {coarse->offset_s, kStep_s, kFineStep_s}, as_mounted);
    if (!fine || std::abs(fine->offset_s) > kMaxOffset_s + kStep_s - 0.5 * kFineStep_s)
        return std::nullopt;
    return fine;
}

}  // namespace

void RotationSpans::add(const VisionRotation& rotation) {
    if (open_.to_ns == rotation.from_ns && open_.to_ns > open_.from_ns) {
        open_.q_from_to = open_.q_from_to * rotation.q_from_to;
        open_.to_ns = rotation.to_ns;
    } else {
        open_ = rotation;
    }
    if (open_.to_ns - open_.from_ns < kMinSpan_ns) return;
    spans_.push_back({open_.from_ns,
                      open_.to_ns,
                      base::vector_from_rotation(open_.q_from_to.normalized()) /
                          base::to_s(open_.to_ns - open_.from_ns)});
    open_ = {};
}

// Returns true if the rates differ from those of vision by a factor, and by little else.
bool is_scaled(const Fit& fit) {
    return std::abs(fit.scale - 1.0) > kMaxScaleError && fit.rate_rad_s > kMinScaledRate_rad_s &&
           fit.scaled_share < kScaledShare * fit.residual_share;
}

GyroscopeJudgement judge_gyroscope(const std::vector<types::ImuSample>& samples,
                                   const std::vector<RotationSpan>& spans) {
    GyroscopeJudgement judgement;
    if (spans.empty()) return judgement;
    const std::vector<RotationSpan> last(
        spans.end() - static_cast<std::ptrdiff_t>(std::min(spans.size(), kMaxSpans)), spans.end());
    const std::int64_t reach_ns = base::to_ns(kMaxOffset_s + kStep_s);
    const GyroscopePath path(
        samples, last.front().from_ns - reach_ns, last.back().to_ns + reach_ns);
    if (const auto bias_rad_s = impossible_bias_rad_s(path, last)) {
        judgement.fit = GyroscopeFit::Contradicts;
        judgement.unexplained_share = 1.0;
        judgement.fault = GyroscopeFault::Biased;
        judgement.bias_rad_s = *bias_rad_s;
        return judgement;
    }
    if (last.size() < kMinSpans) return judgement;
    const Eigen::Matrix3d as_mounted = Eigen::Matrix3d::Identity();
    const auto near = best_fit(path, last, {}, as_mounted);
    if (!near || near->rate_rad_s < kMinRate_rad_s) return judgement;
    judgement.time_offset_s = near->offset_s;
    judgement.unexplained_share = near->unexplained;
    if (is_scaled(*near)) {
        judgement.fit = GyroscopeFit::Contradicts;
        judgement.fault = GyroscopeFault::Scaled;
        judgement.scale = near->scale;
        return judgement;
    }
    if (near->unexplained < kFits && !is_at_edge(*near)) {
        judgement.fit = GyroscopeFit::Fits;
        return judgement;
    }
    if (near->unexplained < kFits)
        if (const auto beyond = fit_beyond(path, last, *near)) {
            judgement.fit = GyroscopeFit::FitsShifted;
            judgement.time_offset_s = beyond->offset_s;
            return judgement;
        }
    if (last.size() < kMinSpansToShift) return judgement;
    const auto far = far_fit(path, last);
    if (far && far->unexplained < kFits &&
        far->unexplained < kMaxUnexplainedRatio * near->unexplained) {
        judgement.fit = std::abs(far->offset_s) > kNearOffset_s ? GyroscopeFit::FitsShifted
                                                                : GyroscopeFit::Fits;
        judgement.time_offset_s = far->offset_s;
        return judgement;
    }
    if (near->unexplained < kFits) judgement.fit = GyroscopeFit::Fits;
    if (near->unexplained <= kContradicts) return judgement;
    judgement.fit = GyroscopeFit::Contradicts;
    explain(path, last, *near, judgement);
    return judgement;
}

std::vector<types::TimeInterval> wrong_times(const std::vector<types::ImuSample>& samples,
                                             const std::vector<RotationSpan>& spans) {
    if (spans.empty()) return {};
    const std::int64_t reach_ns = base::to_ns(kNearOffset_s + kStep_s);
    const GyroscopePath path(
        samples, spans.front().from_ns - reach_ns, spans.back().to_ns + reach_ns);
    const auto fit = best_fit(path, spans, {}, Eigen::Matrix3d(Eigen::Matrix3d::Identity()));
    if (!fit) return {};
    const std::int64_t shift_ns = base::to_ns(fit->offset_s);
    std::vector<Difference> differences;
    for (const RotationSpan& span : spans) {
        const std::int64_t from_ns = span.from_ns + shift_ns;
        const std::int64_t to_ns = span.to_ns + shift_ns;
        if (!path.covers(from_ns, to_ns)) continue;
        const Eigen::Vector3d rate = path.rotation(from_ns, to_ns) / base::to_s(to_ns - from_ns);
        differences.push_back({{span.from_ns, span.to_ns}, span.rate_body - fit->mounting * rate});
    }
    return wrong_times(differences, kWrongRate_rad_s);
}

}  // namespace divemesh::imu
