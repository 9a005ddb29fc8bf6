#include "worker/optimisation/motion_variances.hpp"

namespace divemesh::optimisation {

std::vector<MotionVariance> summed_variances(const std::vector<types::MotionSigma>& sigmas,
                                             std::size_t from,
                                             std::size_t to) {
    std::vector<MotionVariance> sums = {{}};
    for (std::size_t i = from + 1; i <= to; ++i) {
        MotionVariance sum = sums.back();
        sum.position_m2 += sigmas[i].position_m * sigmas[i].position_m;
        sum.rotation_rad2 += sigmas[i].rotation_rad * sigmas[i].rotation_rad;
        sums.push_back(sum);
    }
    return sums;
}

}  // namespace divemesh::optimisation
