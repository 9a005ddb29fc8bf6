#include "worker/dive/clipped_readings.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace divemesh::dive {
namespace {

constexpr std::size_t kMinRows = 10;
constexpr std::size_t kMinRun = 3;  // rows in succession
// The turn of a swing fills the last step of a coarse sensor 2.4 times as often as the step before:
// 1 / (sqrt(2) - 1).
constexpr double kMinRatio = 5.0;
// Below this extent a sensor that rests shows nothing but its resolution.
constexpr double kMinExtent_steps = 50.0;
constexpr double kMaxShare = 0.01;

// Returns the min difference between successive values.
double smallest_step(const std::vector<double>& values) {
    double min_step = std::numeric_limits<double>::infinity();
    for (std::size_t i = 1; i < values.size(); ++i) {
        const double step = std::abs(values[i] - values[i - 1]);
        if (step > 0.0) min_step = std::min(min_step, step);
    }
    return min_step;
}

std::size_t longest_run(const std::vector<double>& values, double value) {
    std::size_t max_run = 0;
    std::size_t run = 0;
    for (const double v : values) {
        run = v == value ? run + 1 : 0;
        max_run = std::max(max_run, run);
    }
    return max_run;
}

// Adds the rows in which an axis stays at a value that no other exceeds.
void add_clipped(const std::vector<double>& values,
                 double extreme,
                 double step,
                 ClippedReadings& clipped) {
    std::vector<std::size_t> found;
    double num_before = 0.0;  // one step before the extreme
    for (std::size_t i = 0; i < values.size(); ++i) {
        if (values[i] == extreme)
            found.push_back(i);
        else if (std::abs(values[i] - extreme) < 1.5 * step)
            ++num_before;
    }
    if (found.size() < kMinRows || static_cast<double>(found.size()) < kMinRatio * num_before ||
        longest_run(values, extreme) < kMinRun)
        return;
    clipped.limit =
        clipped.rows.empty() ? std::abs(extreme) : std::min(clipped.limit, std::abs(extreme));
    clipped.rows.insert(clipped.rows.end(), found.begin(), found.end());
}

template <typename Reading>
ClippedReadings clipped_readings(const std::vector<types::ImuSample>& samples,
                                 const Reading& reading) {
    ClippedReadings clipped;
    if (samples.empty()) return clipped;
    for (int axis = 0; axis < 3; ++axis) {
        std::vector<double> values;
        values.reserve(samples.size());
        for (const types::ImuSample& sample : samples) values.push_back(reading(sample)[axis]);
        const auto [min, max] = std::ranges::minmax_element(values);
        const double step = smallest_step(values);
        if (!(*max - *min >= kMinExtent_steps * step)) continue;
        add_clipped(values, *min, step, clipped);
        add_clipped(values, *max, step, clipped);
    }
    std::ranges::sort(clipped.rows);
    clipped.rows.erase(std::unique(clipped.rows.begin(), clipped.rows.end()), clipped.rows.end());
    return clipped;
}

}  // namespace

bool ClippedReadings::spoil(std::size_t num_rows) const {
    return static_cast<double>(rows.size()) > kMaxShare * static_cast<double>(num_rows);
}

ClippedReadings clipped_rates(const std::vector<types::ImuSample>& samples) {
    return clipped_readings(samples, [](const types::ImuSample& sample) -> const Eigen::Vector3d& {
        return sample.angular_velocity_imu;
    });
}

ClippedReadings clipped_forces(const std::vector<types::ImuSample>& samples) {
    return clipped_readings(samples, [](const types::ImuSample& sample) -> const Eigen::Vector3d& {
        return sample.acceleration_imu;
    });
}

}  // namespace divemesh::dive
