#include "worker/imu/judge_pressure.hpp"

#include <Eigen/Core>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "worker/stats/median.hpp"
#include "worker/stats/robust.hpp"

namespace divemesh::imu {
namespace {

constexpr std::int64_t kBin_ns = 500'000'000;
constexpr std::size_t kBinsOfChange = 10;
constexpr std::size_t kMinChanges = 16;  // thirteen seconds
constexpr double kKept = 0.9;            // share of the changes
constexpr double kUsualNoise_m = 0.05;   // of a change, by waves above and by vision
constexpr double kMinNoise_m = 0.01;     // what is common to all changes does not show in them
constexpr double kKnownTilt_rad = 0.1;   // of the path, with what the accelerometer's bias does
constexpr double kUnknownTilt_rad = 0.4;
// A calibration that is off by as much is what the pressure sensor is to tell.
constexpr double kMaxScaleError = 0.2;
constexpr double kContradicts_sigmas = 4.0;
constexpr double kMaxError_m = 5.0 * kUsualNoise_m;
// Share of the readings at one end that is no swing: of a sine a tenth is as near to its crest.
constexpr double kHeld = 0.25;
constexpr double kHeldStep = 0.02;  // of the range of the readings
constexpr double kReversed = 0.5;   // of a scale from -1
constexpr std::size_t kBinsBesideStep = 5;
constexpr std::int64_t kMaxBesideStep_ns = 12'000'000'000;
constexpr double kMinStep_m = 0.2;
constexpr double kLasting = 0.3;  // share by which the rest of the dive may differ from a step
// Share of the changes that a step does not span. With them alone the fit is the same as without
// the step (least trimmed squares, Rousseeuw 1984).
constexpr double kUnspanned = 0.75;
constexpr int kTrims = 4;
constexpr double kStep_sigmas = 8.0;

// The readings of half a second: their median, and where the body was at their mean time.
struct Bin {
    std::int64_t time_ns = 0;
    double depth_m = 0.0;
    Eigen::Vector3d p_world = Eigen::Vector3d::Zero();
};

struct Change {
    double depth_m = 0.0;
    Eigen::Vector3d path_m = Eigen::Vector3d::Zero();  // x, y, -z
    double error_m = 0.0;
};

// Returns the position at a time within the trajectory, by a line between two poses.
Eigen::Vector3d position_at(const types::Trajectory& trajectory, std::int64_t time_ns) {
    const auto after =
        std::ranges::lower_bound(trajectory, time_ns, {}, &types::StampedPose::timestamp_ns);
    if (after == trajectory.begin()) return after->T_world_imu.translation();
    const auto before = after - 1;
    const double share = static_cast<double>(time_ns - before->timestamp_ns) /
                         static_cast<double>(after->timestamp_ns - before->timestamp_ns);
    return (1.0 - share) * before->T_world_imu.translation() +
           share * after->T_world_imu.translation();
}

std::vector<Bin> bins_of(const std::vector<types::PressureSample>& pressure,
                         const types::Trajectory& trajectory) {
    std::vector<Bin> bins;
    if (trajectory.empty()) return bins;
    auto sample = std::ranges::lower_bound(
        pressure, trajectory.front().timestamp_ns, {}, &types::PressureSample::timestamp_ns);
    const std::int64_t last_ns = trajectory.back().timestamp_ns;
    while (sample != pressure.end() && sample->timestamp_ns <= last_ns) {
        const std::int64_t first_ns = sample->timestamp_ns;
        std::vector<double> depths;
        std::int64_t sum_ns = 0;  // since the first
        for (; sample != pressure.end() && sample->timestamp_ns <= last_ns &&
               sample->timestamp_ns - first_ns < kBin_ns;
             ++sample) {
            depths.push_back(sample->depth_m);
            sum_ns += sample->timestamp_ns - first_ns;
        }
        const std::int64_t time_ns = first_ns + sum_ns / std::ssize(depths);
        bins.push_back({time_ns, stats::median(depths), position_at(trajectory, time_ns)});
    }
    return bins;
}

bool is_broken(const Bin& from, const Bin& to, const types::Breaks& breaks_ns) {
    const auto lost = std::upper_bound(breaks_ns.begin(), breaks_ns.end(), from.time_ns);
    return lost != breaks_ns.end() && *lost <= to.time_ns;
}

// Returns the changes between bins ten apart, where nothing was lost between them.
std::vector<Change> changes_of(const std::vector<Bin>& bins, const types::Breaks& breaks_ns) {
    std::vector<Change> changes;
    for (std::size_t i = kBinsOfChange; i < bins.size(); ++i) {
        const Bin& from = bins[i - kBinsOfChange];
        const Bin& to = bins[i];
        if (is_broken(from, to, breaks_ns)) continue;
        const Eigen::Vector3d way = to.p_world - from.p_world;
        changes.push_back({to.depth_m - from.depth_m, {way.x(), way.y(), -way.z()}});
    }
    return changes;
}

// The tilts and the scale, and how far they are known.
struct Fit {
    Eigen::Vector3d slopes = Eigen::Vector3d::Zero();
    double scale_sigma = 0.0;
};

// Fits the changes and sorts them by their errors.
Fit fit_changes(std::size_t num, double noise_m, double tilt_rad, std::vector<Change>& changes) {
    // Changes that overlap repeat the same noise.
    const double variance_m2 = noise_m * noise_m * static_cast<double>(kBinsOfChange);
    Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
    information.diagonal() << 1.0, 1.0, 0.0;
    information *= 1.0 / (tilt_rad * tilt_rad);
    information(2, 2) = 1e-6;  // a dive that never changes its depth
    Eigen::Vector3d right = Eigen::Vector3d::Zero();
    for (std::size_t i = 0; i < num; ++i) {
        information += changes[i].path_m * changes[i].path_m.transpose() / variance_m2;
        right += changes[i].path_m * changes[i].depth_m / variance_m2;
    }
    const Eigen::Matrix3d covariance = information.inverse();
    Fit fit{covariance * right, std::sqrt(covariance(2, 2))};
    for (Change& change : changes)
        change.error_m = std::abs(change.depth_m - fit.slopes.dot(change.path_m));
    std::sort(changes.begin(), changes.end(), [](const Change& a, const Change& b) {
        return a.error_m < b.error_m;
    });
    return fit;
}

double rms_error_m(std::size_t num, const std::vector<Change>& changes) {
    double squares = 0.0;
    for (std::size_t i = 0; i < num; ++i) squares += changes[i].error_m * changes[i].error_m;
    return std::sqrt(squares / static_cast<double>(num));
}

double median_of(std::vector<double>::const_iterator begin,
                 std::vector<double>::const_iterator end) {
    return stats::median(std::vector<double>(begin, end));
}

// Returns the largest step of what the fit leaves of the depths; 0 where none stands out or lasts.
double step_m(const std::vector<Bin>& bins, const types::Breaks& breaks_ns, const Fit& fit) {
    std::vector<double> rests_m;
    rests_m.reserve(bins.size());
    for (const Bin& bin : bins)
        rests_m.push_back(bin.depth_m - fit.slopes.dot(Eigen::Vector3d(
                                            bin.p_world.x(), bin.p_world.y(), -bin.p_world.z())));
    std::vector<double> sizes_m;
    double largest_m = 0.0;
    auto largest_at = rests_m.cbegin();
    for (std::size_t i = kBinsBesideStep; i + kBinsBesideStep <= bins.size(); ++i) {
        const Bin& from = bins[i - kBinsBesideStep];
        const Bin& to = bins[i + kBinsBesideStep - 1];
        if (to.time_ns - from.time_ns > kMaxBesideStep_ns || is_broken(from, to, breaks_ns))
            continue;
        const auto at = rests_m.cbegin() + static_cast<std::ptrdiff_t>(i);
        constexpr std::ptrdiff_t kBeside = kBinsBesideStep;
        const double change_m = median_of(at, at + kBeside) - median_of(at - kBeside, at);
        sizes_m.push_back(std::abs(change_m));
        if (std::abs(change_m) <= std::abs(largest_m)) continue;
        largest_m = change_m;
        largest_at = at;
    }
    if (sizes_m.empty()) return 0.0;
    const double sigma_m = stats::kSigmasPerMad * stats::median(sizes_m);
    if (std::abs(largest_m) < std::max(kMinStep_m, kStep_sigmas * sigma_m)) return 0.0;
    // Waves and a sensor that lags behind a descent go back; a zero does not.
    const double lasting_m =
        median_of(largest_at, rests_m.cend()) - median_of(rests_m.cbegin(), largest_at);
    return std::abs(lasting_m / largest_m - 1.0) < kLasting ? largest_m : 0.0;
}

// Returns the fit of the changes that fit best. Sorts them by their errors.
Fit fit_unspanned(double tilt_rad, Fit fit, std::vector<Change>& changes) {
    const auto num = static_cast<std::size_t>(kUnspanned * static_cast<double>(changes.size()));
    for (int i = 0; i < kTrims; ++i)
        fit = fit_changes(num, std::max(kMinNoise_m, rms_error_m(num, changes)), tilt_rad, changes);
    return fit;
}

// Returns the share of the readings that stay at the highest or the lowest.
double held_share(const std::vector<types::PressureSample>& pressure) {
    std::vector<double> depths;
    depths.reserve(pressure.size());
    for (const types::PressureSample& sample : pressure) depths.push_back(sample.depth_m);
    const auto [min, max] = std::minmax_element(depths.begin(), depths.end());
    const double step = kHeldStep * (*max - *min);
    const auto num_at = [&](double end) {
        return std::count_if(depths.begin(), depths.end(), [&](double depth) {
            return std::abs(depth - end) <= step;
        });
    };
    return static_cast<double>(std::max(num_at(*min), num_at(*max))) /
           static_cast<double>(depths.size());
}

}  // namespace

PressureJudgement judge_pressure(const std::vector<types::PressureSample>& pressure,
                                 const types::Trajectory& trajectory,
                                 const types::Breaks& breaks_ns,
                                 bool vertical_is_known) {
    const std::vector<Bin> bins = bins_of(pressure, trajectory);
    std::vector<Change> changes = changes_of(bins, breaks_ns);
    if (changes.size() < kMinChanges) return {};
    const double tilt_rad = vertical_is_known ? kKnownTilt_rad : kUnknownTilt_rad;
    fit_changes(changes.size(), kUsualNoise_m, tilt_rad, changes);
    const auto num = static_cast<std::size_t>(kKept * static_cast<double>(changes.size()));
    const double noise_m = std::max(kMinNoise_m, rms_error_m(num, changes));
    const Fit fit = fit_changes(num, noise_m, tilt_rad, changes);
    PressureJudgement judgement;
    judgement.scale = fit.slopes.z();
    judgement.error_m = rms_error_m(num, changes);
    judgement.held_share = held_share(pressure);
    const double limit = std::max(kMaxScaleError, kContradicts_sigmas * fit.scale_sigma);
    judgement.step_m = step_m(bins, breaks_ns, fit_unspanned(tilt_rad, fit, changes));
    const bool is_scaled = std::abs(judgement.scale - 1.0) >= limit;
    // A sensor that is wrong by a factor may have errors that are larger by the same factor.
    const double times = is_scaled ? std::max(1.0, std::abs(judgement.scale)) : 1.0;
    const bool explained = judgement.error_m < times * kMaxError_m;
    if (explained && !is_scaled) {
        if (judgement.step_m != 0.0) judgement.fault = PressureFault::Stepped;
        return judgement;
    }
    if (judgement.held_share > kHeld)
        judgement.fault = PressureFault::Held;
    else if (!explained)
        judgement.fault = PressureFault::Unexplained;
    else
        judgement.fault = std::abs(judgement.scale + 1.0) < kReversed ? PressureFault::Reversed
                                                                      : PressureFault::Scaled;
    return judgement;
}

}  // namespace divemesh::imu
