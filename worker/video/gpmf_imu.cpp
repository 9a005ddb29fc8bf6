#include "worker/video/gpmf_imu.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "worker/base/seconds.hpp"

namespace divemesh::video {
namespace {

// Payloads further off the line belong to a recording that paused: each keeps its own time then.
constexpr double kMaxOffLine_s = 0.05;

// Some samples of a sensor that a payload holds.
struct SampleRun {
    std::int64_t first = 0;  // its number since the recording began
    double stamp_s = 0.0;
    double duration_s = 0.0;
    const std::vector<Eigen::Vector3d>* values = nullptr;
};

struct TimedVector {
    double time_s = 0.0;
    Eigen::Vector3d value = Eigen::Vector3d::Zero();
};

// Returns the runs of a sensor. Their numbers are those that the camera counted, if they rise.
std::vector<SampleRun> runs_of(const std::vector<GpmfPayload>& payloads,
                               const std::vector<GpmfMotion>& motions,
                               GpmfSamples GpmfMotion::*sensor) {
    std::vector<SampleRun> runs;
    std::int64_t next = 0;
    for (std::size_t k = 0; k < payloads.size(); ++k) {
        const GpmfSamples& samples = motions[k].*sensor;
        if (samples.values.empty()) continue;
        const std::int64_t num = std::ssize(samples.values);
        next = std::max(next, samples.num_until_here.value_or(0) - num);
        runs.push_back({next,
                        base::to_s(payloads[k].stamp_ns),
                        base::to_s(payloads[k].duration_ns),
                        &samples.values});
        next += num;
    }
    return runs;
}

// A sample's time by its number.
struct SampleClock {
    double start_s = 0.0;
    double period_s = 0.0;

    double at(std::int64_t number) const {
        return start_s + period_s * static_cast<double>(number);
    }
};

// Returns the line through the beginnings of all runs and the end of the last one; nullopt if they
// are not on one.
std::optional<SampleClock> clock_of(const std::vector<SampleRun>& runs) {
    std::vector<std::pair<double, double>> points;  // number, time
    points.reserve(runs.size() + 1);
    for (const SampleRun& run : runs)
        points.emplace_back(static_cast<double>(run.first), run.stamp_s);
    const SampleRun& last = runs.back();
    if (last.duration_s > 0.0)
        points.emplace_back(static_cast<double>(last.first + std::ssize(*last.values)),
                            last.stamp_s + last.duration_s);
    double mean_number = 0.0;
    double mean_s = 0.0;
    for (const auto& [number, time_s] : points) {
        mean_number += number / static_cast<double>(points.size());
        mean_s += time_s / static_cast<double>(points.size());
    }
    double covariance = 0.0;
    double variance = 0.0;
    for (const auto& [number, time_s] : points) {
        covariance += (number - mean_number) * (time_s - mean_s);
        variance += (number - mean_number) * (number - mean_number);
    }
    if (!(variance > 0.0) || !(covariance > 0.0)) return std::nullopt;
    const double period_s = covariance / variance;
    const SampleClock clock{mean_s - period_s * mean_number, period_s};
    for (const auto& [number, time_s] : points)
        if (std::abs(clock.start_s + period_s * number - time_s) > kMaxOffLine_s)
            return std::nullopt;
    return clock;
}

std::vector<TimedVector> timed(const std::vector<SampleRun>& runs) {
    std::vector<TimedVector> samples;
    if (runs.empty()) return samples;
    const auto clock = clock_of(runs);
    for (std::size_t k = 0; k < runs.size(); ++k) {
        const SampleRun& run = runs[k];
        const auto num = static_cast<double>(run.values->size());
        const double until_s =
            k + 1 < runs.size() ? runs[k + 1].stamp_s : run.stamp_s + run.duration_s;
        for (std::size_t i = 0; i < run.values->size(); ++i) {
            const double time_s =
                clock ? clock->at(run.first + static_cast<std::int64_t>(i))
                      : run.stamp_s + static_cast<double>(i) / num * (until_s - run.stamp_s);
            if (samples.empty() || time_s > samples.back().time_s)
                samples.push_back({time_s, (*run.values)[i]});
        }
    }
    return samples;
}

}  // namespace

GpmfImu imu_of(const std::vector<GpmfPayload>& payloads) {
    GpmfImu imu;
    std::vector<GpmfMotion> motions;
    motions.reserve(payloads.size());
    for (const GpmfPayload& payload : payloads) {
        motions.push_back(parse_gpmf(payload.bytes));
        imu.is_damaged = imu.is_damaged || motions.back().is_damaged;
    }
    const auto rates = timed(runs_of(payloads, motions, &GpmfMotion::gyroscope));
    const auto forces = timed(runs_of(payloads, motions, &GpmfMotion::accelerometer));
    std::size_t after = 1;
    for (const TimedVector& rate : rates) {
        while (after < forces.size() && forces[after].time_s < rate.time_s) ++after;
        if (after >= forces.size()) break;
        const TimedVector& from = forces[after - 1];
        const TimedVector& to = forces[after];
        if (rate.time_s < from.time_s) continue;
        const double share = (rate.time_s - from.time_s) / (to.time_s - from.time_s);
        imu.samples.push_back(
            {base::to_ns(rate.time_s), rate.value, (1.0 - share) * from.value + share * to.value});
    }
    return imu;
}

}  // namespace divemesh::video
