#include "worker/pipeline/join_sources.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <string>
#include <utility>

#include "worker/base/text.hpp"
#include "worker/optimisation/align_heading.hpp"
#include "worker/stats/median.hpp"

namespace divemesh::pipeline {
namespace {

using optimisation::OutsidePoint;

constexpr double kRejected_sigmas = 4.0;
constexpr double kMedianOfTwo = 1.1774;  // of the length of a normal vector in the plane, sigmas
constexpr double kMaxSigmaFactor = 4.0;
constexpr double kDoubtful = 1.5;  // sigma factor from which on the cause is looked for
constexpr double kMinUsedShare = 0.5;
constexpr std::size_t kMinForSpread = 8;  // points
constexpr int kMaxRounds = 6;
constexpr double kSettled = 1.1;        // by which a factor still changes
constexpr double kMinDetermined = 2.0;  // directions of the path that judge its sigmas
// A wrong cause explains so much of the residuals that less than this part of them is left.
constexpr double kExplained = 0.6;
constexpr double kMinLogRatio = 10.0;     // of the likelihoods with and without a cause
constexpr double kMinShiftedShare = 0.7;  // of the points that a shifted clock leaves on the path
constexpr double kMaxClock_s = 120.0;
constexpr double kMinClock_s = 2.0;
constexpr double kClockStep_s = 1.0;
constexpr std::size_t kMaxDiagnosed = 40;  // points

std::vector<OutsidePoint> thinned(const std::vector<OutsidePoint>& points) {
    std::vector<OutsidePoint> some;
    const std::size_t stride = 1 + points.size() / kMaxDiagnosed;
    for (std::size_t i = 0; i < points.size(); i += stride) some.push_back(points[i]);
    return some;
}

double best_median(const std::vector<OutsidePoint>& points) {
    if (points.size() < kMinForSpread) return std::numeric_limits<double>::infinity();
    return optimisation::median_residual_sigmas(points, optimisation::align_heading(points));
}

// Returns the shift of the clock with which a rigid path fits the positions best, s; 0: none is
// clearly better.
double best_clock_s(const PointsAt& points_at, std::size_t source) {
    const auto at = [&](double later_s) { return thinned(points_at(later_s)[source].points); };
    const std::vector<OutsidePoint> points = at(0.0);
    const double as_stated = best_median(points);
    double best_s = 0.0;
    double best = as_stated;
    for (double later_s = -kMaxClock_s; later_s <= kMaxClock_s; later_s += kClockStep_s) {
        const std::vector<OutsidePoint> shifted = at(later_s);
        if (static_cast<double>(shifted.size()) <
            kMinShiftedShare * static_cast<double>(points.size()))
            continue;
        const double median = best_median(shifted);
        if (median >= best) continue;
        best = median;
        best_s = later_s;
    }
    return best < kExplained * as_stated && std::abs(best_s) >= kMinClock_s ? best_s : 0.0;
}

// Returns the negative log posterior of a path that is joined with points of one source alone, its
// residuals counted as if there were `num` points.
using JoinedCost = std::function<double(const std::vector<OutsidePoint>& points, std::size_t num)>;

// Returns the likely cause if positions do not fit the path; "" if none is found. A cause is one
// only if the path joined with what it explains is far more likely: a path that drifts fits any
// positions badly as long as it is rigid.
std::string cause_of(const PointsAt& points_at, std::size_t source, const JoinedCost& joined_cost) {
    std::vector<OutsidePoint> points = points_at(0.0)[source].points;
    if (points.size() < kMinForSpread) return "";
    const double limit = joined_cost(points, points.size()) - kMinLogRatio;
    for (OutsidePoint& point : points) point.p_site.x() = -point.p_site.x();
    if (joined_cost(points, points.size()) < limit)
        return "they fit a mirrored path: two coordinates are exchanged or one has the wrong sign";
    const double later_s = best_clock_s(points_at, source);
    if (later_s == 0.0 || joined_cost(points_at(later_s)[source].points, points.size()) >= limit)
        return "";
    return "they fit if their clock is " + base::fixed(std::abs(later_s), 0) + " s " +
           (later_s > 0.0 ? "behind" : "ahead of") + " that of the cameras";
}

// Returns the factor by which the sigma of a mean of many is larger because neighbours are alike:
// sqrt(1 + 2 sum rho), with the autocorrelations of the residuals up to the first that is not
// clearly positive (Bartlett 1946).
double correlation_factor(const std::vector<Eigen::Vector3d>& residuals_m) {
    double sum = 1.0;
    double variance = 0.0;
    for (const Eigen::Vector3d& r : residuals_m) variance += r.head<2>().squaredNorm();
    if (variance <= 0.0) return 1.0;
    const std::size_t num = residuals_m.size();
    for (std::size_t lag = 1; lag < num / 3; ++lag) {
        double covariance = 0.0;
        for (std::size_t i = lag; i < num; ++i)
            covariance += residuals_m[i].head<2>().dot(residuals_m[i - lag].head<2>());
        const double rho = covariance / variance;
        if (rho < 2.0 / std::sqrt(static_cast<double>(num))) break;
        sum += 2.0 * rho;
    }
    return std::sqrt(sum);
}

// One source while it is judged.
struct Judged {
    SourcePoints given;
    bool used = true;
    bool was_diagnosed = false;

    double factor() const {
        return given.agreement.sigma_factor * given.agreement.correlation_factor;
    }
};

// Judges a source by the residuals of its points, in their order.
void judge(const std::vector<Eigen::Vector3d>& residuals_m, Judged& source) {
    types::SourceAgreement& agreement = source.given.agreement;
    const std::vector<OutsidePoint>& points = source.given.points;
    std::vector<double> sigmas;
    for (std::size_t i = 0; i < points.size(); ++i)
        sigmas.push_back(residuals_m[i].head<2>().norm() / points[i].sigma_h_m);
    if (points.size() >= kMinForSpread)
        agreement.sigma_factor = std::max(1.0, stats::upper_median(sigmas) / kMedianOfTwo);
    agreement.num_rejected = 0;
    double squares_m2 = 0.0;
    std::vector<Eigen::Vector3d> kept_m;
    for (std::size_t i = 0; i < points.size(); ++i) {
        if (sigmas[i] > kRejected_sigmas * agreement.sigma_factor) {
            ++agreement.num_rejected;
            continue;
        }
        squares_m2 += residuals_m[i].head<2>().squaredNorm();
        kept_m.push_back(residuals_m[i]);
    }
    if (points.size() >= kMinForSpread) agreement.correlation_factor = correlation_factor(kept_m);
    agreement.rms_m =
        kept_m.empty() ? 0.0 : std::sqrt(squares_m2 / static_cast<double>(kept_m.size()));
}

// Returns why a source must be left out; "" if it may be used.
std::string reason_against(const PointsAt& points_at,
                           std::size_t index,
                           const JoinedCost& joined_cost,
                           Judged& source) {
    const types::SourceAgreement& agreement = source.given.agreement;
    const auto num = static_cast<double>(source.given.points.size());
    const double used_share = 1.0 - static_cast<double>(agreement.num_rejected) / num;
    const bool fits = agreement.sigma_factor <= kMaxSigmaFactor && used_share >= kMinUsedShare;
    if (agreement.sigma_factor < kDoubtful && fits) return "";
    if (!source.was_diagnosed && agreement.kind != "control_points") {
        source.was_diagnosed = true;
        if (std::string cause = cause_of(points_at, index, joined_cost); !cause.empty())
            return cause;
    }
    if (fits) return "";
    return "they are " + base::fixed(agreement.sigma_factor, 1) +
           " times as far from the path as their sigma says, and " +
           std::to_string(agreement.num_rejected) + " of " +
           std::to_string(source.given.points.size()) +
           " fit it even less: the coordinate system, the place of the instrument (T_BS) or the "
           "sigma may be wrong";
}

// Returns the points of the sources that are used, with their present sigmas.
std::vector<OutsidePoint> points_to_join(const std::vector<Judged>& sources) {
    std::vector<OutsidePoint> all;
    for (std::size_t s = 0; s < sources.size(); ++s) {
        if (!sources[s].used) continue;
        for (OutsidePoint point : sources[s].given.points) {
            point.sigma_h_m *= sources[s].factor();
            point.sigma_v_m *= sources[s].factor();
            point.source = s;
            all.push_back(point);
        }
    }
    return all;
}

// Returns the alignment by the used source that fits best.
Eigen::Isometry3d start_of(const std::vector<Judged>& sources) {
    Eigen::Isometry3d best = Eigen::Isometry3d::Identity();
    double least = std::numeric_limits<double>::infinity();
    for (const Judged& source : sources) {
        if (!source.used || source.given.points.empty()) continue;
        const Eigen::Isometry3d T = optimisation::align_heading(source.given.points);
        // A single point fits any heading; so do a few.
        const double median = optimisation::median_residual_sigmas(source.given.points, T) +
                              10.0 / static_cast<double>(source.given.points.size());
        if (median >= least) continue;
        least = median;
        best = T;
    }
    return best;
}

// Returns by how much the sigmas of the path have to grow to agree with how far it was moved.
double growth_of_prior(const optimisation::JoinedPath& joined) {
    if (joined.num_determined < kMinDetermined) return 1.0;
    return std::max(1.0, std::sqrt(joined.moved_squares / joined.num_determined));
}

}  // namespace

JoinedSources join_sources(const PathToJoin& to_join,
                           const PointsAt& points_at,
                           const std::vector<optimisation::OutsideMotion>& motions,
                           const optimisation::JoinSettings& settings) {
    std::vector<Judged> sources;
    optimisation::JoinSettings with_offsets = settings;
    for (SourcePoints& given : points_at(0.0)) {
        with_offsets.offset_sigmas_m.push_back(given.offset_sigma_m);
        sources.push_back({std::move(given)});
        sources.back().used = !sources.back().given.points.empty();
        if (!sources.back().used)
            sources.back().given.agreement.left_out = "none of them belongs to a place of the path";
    }
    const auto joined_cost = [&](const std::vector<OutsidePoint>& points, std::size_t num) {
        std::vector<OutsidePoint> alone = points;
        for (OutsidePoint& point : alone) point.source = 0;
        optimisation::JoinSettings of_one = settings;
        of_one.offset_sigmas_m = {0.0};
        const auto joined = optimisation::join_path(
            to_join.path, to_join.prior, alone, {}, optimisation::align_heading(alone), of_one);
        double cost = 0.0;  // of Student's t in the plane, four degrees of freedom
        for (std::size_t i = 0; i < alone.size(); ++i)
            cost += 3.0 * std::log1p(joined.residuals_m[i].head<2>().squaredNorm() /
                                     (4.0 * alone[i].sigma_h_m * alone[i].sigma_h_m));
        return cost * static_cast<double>(num) / static_cast<double>(alone.size()) +
               0.5 * joined.moved_squares;
    };
    JoinedSources result;
    bool is_final = false;
    for (int round = 0; !is_final; ++round) {
        const std::vector<OutsidePoint> points = points_to_join(sources);
        if (points.empty() && motions.empty()) break;
        result.joined = optimisation::join_path(
            to_join.path, to_join.prior, points, motions, start_of(sources), with_offsets);
        const double growth = growth_of_prior(result.joined);
        is_final = round >= kMaxRounds || points.empty() || (round > 0 && growth < kSettled);
        auto residual = result.joined.residuals_m.begin();
        for (std::size_t s = 0; s < sources.size(); ++s) {
            Judged& source = sources[s];
            if (!source.used) continue;
            const auto end = residual + std::ssize(source.given.points);
            judge({residual, end}, source);
            residual = end;
            source.given.agreement.left_out = reason_against(points_at, s, joined_cost, source);
            source.used = source.given.agreement.left_out.empty();
            if (!source.used) is_final = false;  // the others, without it
        }
        if (!is_final) with_offsets.prior_factor *= growth;
        result.prior_factor = with_offsets.prior_factor;
    }
    for (Judged& source : sources) result.sources.push_back(std::move(source.given.agreement));
    const bool any = !motions.empty() || std::ranges::any_of(sources, &Judged::used);
    result.joined.converged = result.joined.converged && any;
    return result;
}

}  // namespace divemesh::pipeline
