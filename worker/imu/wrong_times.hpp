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

// Returns the times in which the sensor was wrong. `differences` are in order of time. One is wrong
// if it is farther from the median of those up to nine seconds before and after it than
// `min_distance` and than five times the median of such distances over the dive. A wrong time has
// at least 1.6 s of differences; one difference in a row among them may be right.
//
// A gap between wrong differences, in which the images measured nothing, counts as wrong too,
// because a wrong sensor is a likely cause of the gap. A second is added before and after each
// time, because it is not known better when the sensor began to be wrong.
std::vector<types::TimeInterval> wrong_times(const std::vector<Difference>& differences,
                                             double min_distance);

}  // namespace divemesh::imu
