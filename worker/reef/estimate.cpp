#include "worker/reef/estimate.hpp"

#include <cmath>
#include <numeric>

namespace divemesh::worker {
namespace {

double mean_of(const std::vector<double>& values) {
    return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

double deviation_of(const std::vector<double>& values, double mean) {
    double squares = 0.0;
    for (const double value : values) squares += (value - mean) * (value - mean);
    return std::sqrt(squares / static_cast<double>(values.size() - 1));
}

}  // namespace

double student_t_975(int degrees_of_freedom) {
    const double z = 1.959964;
    const double n = degrees_of_freedom;
    const double z3 = z * z * z;
    const double z5 = z3 * z * z;
    const double z7 = z5 * z * z;
    return z + (z3 + z) / (4.0 * n) + (5.0 * z5 + 16.0 * z3 + 3.0 * z) / (96.0 * n * n) +
           (3.0 * z7 + 19.0 * z5 + 17.0 * z3 - 15.0 * z) / (384.0 * n * n * n);
}

Estimate estimate(const Simulated& simulated, double sigma_doubt) {
    constexpr double kTwoSided = 1.959964;
    const double blur = simulated.measured - simulated.blurred;
    double noise = 0.0;  // what it added
    double half_width = 0.0;
    if (simulated.once.size() > 1) {
        const double once = mean_of(simulated.once);
        const double twice = mean_of(simulated.twice);
        noise = 3.0 * once - 2.0 * simulated.measured - twice;
        half_width = student_t_975(static_cast<int>(simulated.once.size()) - 1) *
                     deviation_of(simulated.once, once);
    }
    const double doubt = kTwoSided * std::hypot(2.0 * sigma_doubt * noise, blur);
    half_width = std::hypot(half_width, doubt);
    const double value = simulated.measured - noise + blur;
    return {value, value - half_width, value + half_width};
}

}  // namespace divemesh::worker
