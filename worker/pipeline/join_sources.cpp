#include "worker/pipeline/join_sources.hpp"

#include <algorithm>
#include <cmath>
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
constexpr int kMaxRounds = 3;
// A wrong cause explains so much of the residuals that less than this part of them is left.
constexpr double kExplained = 0.6;
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

// Returns the likely cause if positions do not fit the path; "" if none is found.
std::string cause_of(const PointsAt& points_at, std::size_t source) {
    const auto at = [&](double later_s) { return thinned(points_at(later_s)[source].points); };
    const std::vector<OutsidePoint> points = at(0.0);
    const double as_stated = best_median(points);
    std::vector<OutsidePoint> mirrored = points;
    for (OutsidePoint& point : mirrored) point.p_site.x() = -point.p_site.x();
    if (best_median(mirrored) < kExplained * as_stated)
        return "they fit a mirrored path: two coordinates are exchanged or one has the wrong sign";
    double best_s = 0.0;
    double best = as_stated;
    for (double later_s = -kMaxClock_s; later_s <= kMaxClock_s; later_s += kClockStep_s) {
        const std::vector<OutsidePoint> shifted = at(later_s);
        if (shifted.size() < points.size() / 2) continue;
        const double median = best_median(shifted);
        if (median >= best) continue;
        best = median;
        best_s = later_s;
    }
    if (best < kExplained * as_stated && std::abs(best_s) >= kMinClock_s)
        return "they fit if their clock is " + base::fixed(std::abs(best_s), 0) + " s " +
               (best_s > 0.0 ? "behind" : "ahead of") + " that of the cameras";
    return "";
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
std::string reason_against(const PointsAt& points_at, std::size_t index, Judged& source) {
    const types::SourceAgreement& agreement = source.given.agreement;
    const auto num = static_cast<double>(source.given.points.size());
    const double used_share = 1.0 - static_cast<double>(agreement.num_rejected) / num;
    const bool fits = agreement.sigma_factor <= kMaxSigmaFactor && used_share >= kMinUsedShare;
    if (agreement.sigma_factor < kDoubtful && fits) return "";
    if (!source.was_diagnosed && agreement.kind != "control_points") {
        source.was_diagnosed = true;
        if (const std::string cause = cause_of(points_at, index); !cause.empty()) return cause;
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
    JoinedSources result;
    bool is_final = false;
    for (int round = 0; !is_final; ++round) {
        const std::vector<OutsidePoint> points = points_to_join(sources);
        if (points.empty() && motions.empty()) break;
        result.joined = optimisation::join_path(
            to_join.path, to_join.prior, points, motions, start_of(sources), with_offsets);
        is_final = round >= kMaxRounds || points.empty();
        auto residual = result.joined.residuals_m.begin();
        for (std::size_t s = 0; s < sources.size(); ++s) {
            Judged& source = sources[s];
            if (!source.used) continue;
            const auto end = residual + std::ssize(source.given.points);
            judge({residual, end}, source);
            residual = end;
            source.given.agreement.left_out = reason_against(points_at, s, source);
            source.used = source.given.agreement.left_out.empty();
            if (!source.used) is_final = false;  // the others, without it
        }
    }
    for (Judged& source : sources) result.sources.push_back(std::move(source.given.agreement));
    const bool any = !motions.empty() || std::ranges::any_of(sources, &Judged::used);
    result.joined.converged = result.joined.converged && any;
    return result;
}

}  // namespace divemesh::pipeline
