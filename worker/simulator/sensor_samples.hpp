#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>

#include "worker/base/hashed_random.hpp"
#include "worker/base/seconds.hpp"
#include "worker/simulator/inertial_sensors.hpp"

namespace divemesh::simulator {

// Calls `visit(time from the first frame, timestamp)` at the sensor's sample times.
template <typename Visit>
void for_each_sample(double rate_hz, double duration_s, const Visit& visit) {
    const auto period_ns = static_cast<std::int64_t>(std::llround(1e9 / rate_hz));
    const auto margin_ns = base::to_ns(kSensorMargin_s);
    const auto end_ns = base::to_ns(duration_s) + margin_ns;
    for (std::int64_t t_ns = -margin_ns; t_ns < end_ns + period_ns; t_ns += period_ns)
        visit(base::to_s(t_ns), kFirstFrame_ns + t_ns);
}

// Returns three independent normal numbers.
inline Eigen::Vector3d gaussian3(base::RandomRow& random) {
    const double x = random.gaussian();
    const double y = random.gaussian();
    return {x, y, random.gaussian()};
}

// A slowly varying sum of sines with unit RMS.
class GaussMarkovProcess {
public:
    GaussMarkovProcess(base::RandomRow& random, double period_s) {
        for (Term& term : terms_)
            term = {random.uniform(0.8, 1.25) / period_s,
                    random.uniform(0.0, 2.0 * std::numbers::pi)};
    }
    double at(double t_s) const {
        double sum = 0.0;
        for (const Term& term : terms_)
            sum += std::sin(2.0 * std::numbers::pi * term.frequency_hz * t_s + term.phase);
        return sum * std::sqrt(2.0 / static_cast<double>(terms_.size()));
    }

private:
    struct Term {
        double frequency_hz;
        double phase;
    };
    std::array<Term, 3> terms_{};
};

}  // namespace divemesh::simulator
