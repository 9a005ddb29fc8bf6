#include "worker/imu/wrong_times.hpp"

#include <algorithm>

#include "worker/stats/median.hpp"

namespace divemesh::imu {
namespace {

constexpr std::ptrdiff_t kReach = 30;  // differences: more than twice as long as the wrong time
constexpr double kFar = 8.0;           // medians: noise of three axes is beyond four very seldom
constexpr std::int64_t kMaxPause_ns = 400'000'000;  // one difference
// A shorter time may be one in which the images were wrong: a fish that passes.
constexpr std::int64_t kMinTime_ns = 1'800'000'000;
constexpr std::int64_t kMargin_ns = 500'000'000;

Eigen::Vector3d usual_around(const std::vector<Difference>& differences, std::ptrdiff_t at) {
    const auto first = differences.begin() + std::max<std::ptrdiff_t>(0, at - kReach);
    const auto last =
        differences.begin() + std::min<std::ptrdiff_t>(std::ssize(differences), at + kReach + 1);
    Eigen::Vector3d usual;
    for (int axis = 0; axis < 3; ++axis) {
        std::vector<double> values;
        for (auto near = first; near != last; ++near) values.push_back(near->value[axis]);
        usual[axis] = stats::median(std::move(values));
    }
    return usual;
}

}  // namespace

std::vector<types::TimeInterval> wrong_times(const std::vector<Difference>& differences,
                                             double least) {
    if (differences.empty()) return {};
    std::vector<double> sizes;
    for (std::ptrdiff_t i = 0; i < std::ssize(differences); ++i)
        sizes.push_back(
            (differences[static_cast<std::size_t>(i)].value - usual_around(differences, i)).norm());
    const double limit = std::max(least, kFar * stats::median(sizes));
    std::vector<types::TimeInterval> times;
    for (std::size_t i = 0; i < sizes.size(); ++i) {
        if (sizes[i] <= limit) continue;
        const types::TimeInterval& wrong = differences[i].time;
        if (times.empty() || wrong.from_ns - times.back().to_ns > kMaxPause_ns)
            times.push_back(wrong);
        times.back().to_ns = wrong.to_ns;
    }
    std::erase_if(times, [](const types::TimeInterval& time) {
        return time.to_ns - time.from_ns < kMinTime_ns;
    });
    for (types::TimeInterval& time : times) {
        time.from_ns -= kMargin_ns;
        time.to_ns += kMargin_ns;
    }
    return times;
}

}  // namespace divemesh::imu
