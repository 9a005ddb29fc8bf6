#include "worker/markers/measure_bars.hpp"

#include <algorithm>
#include <cmath>

namespace divemesh::markers {
namespace {

constexpr double kMinSigma_m = 1e-5;
// Error with which an edge between black and white is read, the same for all edges of a tag: 0.1 to
// 0.25 px on dark tags with a tone curve of 1/2.2 and a point spread of a pixel.
constexpr double kEdge_px = 0.2;
// Standard deviation that all printed sizes share where none is stated: printers that fit a sheet
// to their page print it at 94 to 98 %.
constexpr double kPrintingSigma = 0.02;
constexpr int kMinBarsForLeavingOut = 3;
constexpr double kTolerated_sigmas = 3.0;

using Vector12 = Eigen::Matrix<double, 12, 1>;

// Returns d(point)/d(corners): the share of each corner in an end.
double share_of(const dive::MarkerPoint& point, std::size_t corner) {
    if (!point.corner) return 1.0 / dive::kNumTagCorners;
    return static_cast<std::size_t>(*point.corner) == corner ? 1.0 : 0.0;
}

// Returns the derivative of a length along `direction` with respect to the corners, for `sign`
// times this end.
Vector12 gradient(const dive::MarkerPoint& point, const Eigen::Vector3d& direction, double sign) {
    Vector12 result;
    for (std::size_t corner = 0; corner < dive::kNumTagCorners; ++corner)
        result.segment<3>(3 * static_cast<Eigen::Index>(corner)) =
            sign * share_of(point, corner) * direction;
    return result;
}

double variance(const Vector12& gradient, const Marker& marker) {
    return gradient.dot(marker.corner_covariance_m2 * gradient);
}

// Position errors behave like a random walk along the path, limited by the two markers' own
// covariances.
double drift_m2(const Marker& a, const Marker& b, const Eigen::Vector3d& direction, double rate) {
    const double apart = direction.dot((a.drift_covariance_m2 + b.drift_covariance_m2) * direction);
    return std::min(apart, rate * std::abs(a.path_m - b.path_m));
}

const Marker* find(const std::vector<const Marker*>& segment, int id) {
    for (const Marker* marker : segment)
        if (marker->id == id) return marker;
    return nullptr;
}

// Groups the markers by segment. Lengths are measured within one segment, the first that shows both
// ends.
std::vector<std::vector<const Marker*>> by_segment(const std::vector<Marker>& markers) {
    std::vector<std::vector<const Marker*>> segments;
    for (const Marker& marker : markers) {
        if (segments.empty() || segments.back().front()->segment != marker.segment)
            segments.emplace_back();
        segments.back().push_back(&marker);
    }
    return segments;
}

BarMetrics measure(const dive::ScaleBar& known,
                   const std::vector<std::vector<const Marker*>>& segments,
                   const BarErrors& errors) {
    BarMetrics bar;
    bar.name = known.name;
    bar.from = known.from;
    bar.to = known.to;
    bar.known_m = known.distance_m;
    bar.known_sigma_m = known.sigma_m;
    for (const auto& segment : segments) {
        const Marker* a = find(segment, known.from.id);
        const Marker* b = find(segment, known.to.id);
        if (a == nullptr || b == nullptr) continue;
        const Eigen::Vector3d way = b->point(known.to.corner) - a->point(known.from.corner);
        const Eigen::Vector3d direction = way.normalized();
        const Vector12 of_a = gradient(known.from, direction, -1.0);
        const Vector12 of_b = gradient(known.to, direction, 1.0);
        bar.edge_sigma_m = kEdge_px * ((known.from.corner ? a->pixel_m : 0.0) +
                                       (known.to.corner ? b->pixel_m : 0.0));
        double squares = known.sigma_m * known.sigma_m + bar.edge_sigma_m * bar.edge_sigma_m;
        if (a == b)
            squares += variance(of_a + of_b, *a);
        else
            squares += variance(of_a, *a) + variance(of_b, *b) +
                       drift_m2(*a, *b, direction, errors.drift_rate_m2_per_m);
        bar.measured_m = way.norm();
        bar.own_sigma_m = std::max(kMinSigma_m, std::sqrt(squares));
        break;
    }
    return bar;
}

BarMetrics measure_size(const Marker& marker, double size_m, const dive::MarkerPlan& plan) {
    BarMetrics bar;
    bar.name = "size of " + std::to_string(marker.id);
    bar.is_printed_size = true;
    bar.from = bar.to = {marker.id, std::nullopt};
    bar.known_m = size_m;
    bar.known_sigma_m = plan.size_sigma_m;
    Vector12 change = Vector12::Zero();
    double sum = 0.0;
    for (std::size_t i = 0; i < dive::kNumTagCorners; ++i) {
        const std::size_t next = (i + 1) % dive::kNumTagCorners;
        const Eigen::Vector3d edge = marker.corners_world[next] - marker.corners_world[i];
        sum += edge.norm();
        change.segment<3>(3 * static_cast<Eigen::Index>(next)) += 0.25 * edge.normalized();
        change.segment<3>(3 * static_cast<Eigen::Index>(i)) -= 0.25 * edge.normalized();
    }
    bar.measured_m = 0.25 * sum;
    bar.edge_sigma_m = 2.0 * kEdge_px * marker.pixel_m;
    const double squares = plan.size_sigma_m * plan.size_sigma_m +
                           bar.edge_sigma_m * bar.edge_sigma_m + variance(change, marker);
    bar.own_sigma_m = std::max(kMinSigma_m, std::sqrt(squares));
    return bar;
}

// Sums of the least squares; a bar is left out by subtraction.
struct Sums {
    double products = 0.0;
    double squares = 0.0;
    int num = 0;

    void add(const BarMetrics& bar, double sign) {
        const double weight = sign / (bar.own_sigma_m * bar.own_sigma_m);
        products += weight * *bar.measured_m * bar.known_m;
        squares += weight * *bar.measured_m * *bar.measured_m;
        num += sign > 0.0 ? 1 : -1;
    }
    double factor() const { return products / squares; }
    double sigma() const { return 1.0 / std::sqrt(squares); }
};

Sums sums_of(const std::vector<BarMetrics>& bars) {
    Sums sums;
    for (const BarMetrics& bar : bars)
        if (bar.consistent) sums.add(bar, 1.0);
    return sums;
}

// Marks inconsistent bars, starting with the worst, as one wrong bar makes the others look wrong.
void find_inconsistent(std::vector<BarMetrics>& bars) {
    for (BarMetrics& bar : bars) bar.consistent = bar.measured_m.has_value();
    leave_each_out(bars);
    while (sums_of(bars).num >= kMinBarsForLeavingOut) {
        const auto worst =
            std::max_element(bars.begin(), bars.end(), [](const auto& a, const auto& b) {
                return (a.consistent ? a.leave_one_out_sigmas() : 0.0) <
                       (b.consistent ? b.leave_one_out_sigmas() : 0.0);
            });
        if (worst->leave_one_out_sigmas() <= kTolerated_sigmas) return;
        worst->consistent = false;
        leave_each_out(bars);
    }
}

}  // namespace

void leave_each_out(std::vector<BarMetrics>& bars) {
    const Sums all = sums_of(bars);
    for (BarMetrics& bar : bars) {
        if (!bar.measured_m) continue;
        Sums others = all;
        if (bar.consistent) others.add(bar, -1.0);
        if (others.num < 1) continue;
        bar.leave_one_out_error_m = others.factor() * *bar.measured_m - bar.known_m;
        bar.leave_one_out_sigma_m = std::hypot(bar.own_sigma_m, others.sigma() * *bar.measured_m);
    }
}

std::vector<BarMetrics> measure_bars(const std::vector<Marker>& markers,
                                     const dive::MarkerPlan& plan,
                                     const BarErrors& errors) {
    const auto segments = by_segment(markers);
    std::vector<BarMetrics> bars;
    for (const dive::ScaleBar& known : plan.scale_bars)
        bars.push_back(measure(known, segments, errors));
    for (const Marker& marker : markers)
        if (const auto size_m = plan.size_of(marker.id))
            bars.push_back(measure_size(marker, *size_m, plan));
    for (BarMetrics& bar : bars)
        if (bar.measured_m)
            bar.sigma_m =
                std::hypot(bar.own_sigma_m, errors.systematic_scale_sigma * *bar.measured_m);
    find_inconsistent(bars);
    return bars;
}

std::optional<MarkerScale> scale_of(const std::vector<BarMetrics>& bars) {
    const Sums sums = sums_of(bars);
    if (sums.num == 0) return std::nullopt;
    MarkerScale scale;
    scale.factor = sums.factor();
    scale.num_bars = sums.num;
    double chi2 = 0.0;
    for (const BarMetrics& bar : bars) {
        if (!bar.consistent) continue;
        scale.bars.push_back(bar.name);
        const double error = (scale.factor * *bar.measured_m - bar.known_m) / bar.own_sigma_m;
        chi2 += error * error;
    }
    // Birge's ratio: bars that disagree by more than their sigmas had sigmas that were too small.
    const double ratio = sums.num > 1 ? std::sqrt(chi2 / (sums.num - 1)) : 1.0;
    double edges = 0.0;  // edge errors do not average out
    for (const BarMetrics& bar : bars)
        if (bar.consistent)
            edges += *bar.measured_m * bar.edge_sigma_m / (bar.own_sigma_m * bar.own_sigma_m);
    scale.sigma = std::hypot(sums.sigma() * std::max(1.0, ratio), edges / sums.squares);
    return scale;
}

std::optional<MarkerScale> trusted_scale(const std::vector<BarMetrics>& bars) {
    const auto is_unsure = [](const BarMetrics& bar) {
        return bar.is_printed_size && bar.known_sigma_m <= 0.0;
    };
    std::vector<BarMetrics> sure = bars;
    std::erase_if(sure, is_unsure);
    find_inconsistent(sure);
    if (auto scale = scale_of(sure)) return scale;
    auto scale = scale_of(bars);
    if (scale) scale->sigma = std::hypot(scale->sigma, kPrintingSigma * scale->factor);
    return scale;
}

std::optional<Finding> reason_against(const std::optional<MarkerScale>& scale) {
    constexpr double kMaxChange = 0.5;
    constexpr double kMaxSigma = 0.02;
    std::string reason;
    if (!scale)
        reason = "no known distance was measured";
    else if (std::abs(std::log(scale->factor)) > std::log1p(kMaxChange))
        reason = "the known distances require a factor of " + std::to_string(scale->factor) +
                 ", more than any calibration can be wrong by";
    else if (scale->sigma > kMaxSigma * scale->factor)
        reason = "the known distances determine the scale only to " +
                 std::to_string(100.0 * scale->sigma / scale->factor) + " % (standard deviation)";
    if (reason.empty()) return std::nullopt;
    return Finding{
        Severity::Warning,
        "scale_not_corrected",
        "markers.json",
        "the scale was not corrected, although correct_scale was set: " + reason,
        "state size_m or scale_bars in m (docs/markers.md), and swim slowly over the tags"};
}

}  // namespace divemesh::markers
