#include "worker/reef/complexity_relation.hpp"

#include <cmath>
#include <numbers>

namespace divemesh::reef {

double rugosity_of_height_range(double range_m, double resolution_m) {
    return std::hypot(1.0, range_m / (std::numbers::sqrt2 * resolution_m));
}

double fractal_dimension_from(double rugosity, double height_range_m, const Scales& scales) {
    const double range_at_resolution =
        scales.resolution_m * std::sqrt(2.0 * (rugosity * rugosity - 1.0));
    return 3.0 - std::log(range_at_resolution / height_range_m) /
                     std::log(scales.resolution_m / scales.extent_m);
}

}  // namespace divemesh::reef
