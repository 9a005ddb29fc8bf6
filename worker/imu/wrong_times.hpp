#pragma once

#include <Eigen/Core>
#include <vector>

#include "worker/types/sensors_left_out.hpp"

namespace divemesh::imu {

// The error of a sensor over a time: measured less expected. Constant, or slowly
// varying as a bias is, if the sensor is right.
struct Difference {
    types::TimeInterval time;
    Eigen::Vector3d value = Eigen::Vector3d::Zero();
};

// Returns the times in which the differences, in order of time, are far from the median of those up
// to nine seconds before and after: by more than `least` and by more than five times what is usual,
// over about two seconds of differences. One among them may be near. A time without any, in which
// the images told nothing, belongs to the wrong time around it: a sensor that is wrong is a likely
// cause that they did not. A second before and after is added, as it is not known better when
// the sensor began to be wrong.
std::vector<types::TimeInterval> wrong_times(const std::vector<Difference>& differences,
                                             double least);

}  // namespace divemesh::imu
