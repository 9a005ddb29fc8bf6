#include "worker/imu/wrong_times.hpp"

#include <algorithm>

#include "worker/stats/median.hpp"

namespace divemesh::imu {
namespace {

// Twice as long as a wrong time of seconds, and so short that the images hardly drift.
constexpr std::int64_t kReach_ns = 9'000'000'000;
constexpr double kFar = 5.0;  // medians: noise of three axes is beyond three very seldom
constexpr int kMaxRight = 1;  // differences in a row that are right by chance
// A shorter time may be one in which the images were wrong: a fish that passes.
constexpr std::int64_t kMinMeasured_ns = 1'600'000'000;
constexpr std::int64_t kMargin_ns = 1'000'000'000;

struct WrongTime {
    types::TimeInterval time;
    std::int64_t measured_ns = 0;

    void add(const types::TimeInterval& next) {
        if (measured_ns == 0) time = {next.from_ns, next.from_ns};
        measured_ns += next.to_ns - std::max(next.from_ns, time.to_ns);
        time.to_ns = next.to_ns;
    }
};

Eigen::Vector3d usual_around(const std::vector<Difference>& differences, const Difference& at) {
    const auto first = std::lower_bound(differences.begin(),
                                        differences.end(),
                                        at.time.from_ns - kReach_ns,
                                        [](const Difference& difference, std::int64_t time_ns) {
                                            return difference.time.from_ns < time_ns;
                                        });
    Eigen::Vector3d usual;
    for (int axis = 0; axis < 3; ++axis) {
        std::vector<double> values;
        for (auto near = first; near != differences.end(); ++near) {
            if (near->time.from_ns > at.time.from_ns + kReach_ns) break;
            values.push_back(near->value[axis]);
        }
        usual[axis] = stats::median(std::move(values));
    }
    return usual;
}

}  // namespace

std::vector<types::TimeInterval> wrong_times(const std::vector<Difference>& differences,
                                             double min_distance) {
    if (differences.empty()) return {};
    std::vector<double> sizes;
    sizes.reserve(differences.size());
    for (const Difference& at : differences)
        sizes.push_back((at.value - usual_around(differences, at)).norm());
    const double limit = std::max(min_distance, kFar * stats::median(sizes));
    std::vector<WrongTime> found;
    int num_right = 0;  // since the last wrong one
    for (std::size_t i = 0; i < sizes.size(); ++i) {
        if (sizes[i] <= limit) {
            ++num_right;
            continue;
        }
        if (found.empty() || num_right > kMaxRight) found.emplace_back();
        found.back().add(differences[i].time);
        num_right = 0;
    }
    std::vector<types::TimeInterval> times;
    for (const WrongTime& wrong : found)
        if (wrong.measured_ns >= kMinMeasured_ns)
            times.push_back({wrong.time.from_ns - kMargin_ns, wrong.time.to_ns + kMargin_ns});
    return times;
}

}  // namespace divemesh::imu
