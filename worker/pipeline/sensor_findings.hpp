#pragma once

#include <vector>

#include "schemas/finding.hpp"
#include "worker/imu/sensor_watch.hpp"

namespace divemesh::pipeline {

// Returns what the user is told about sensors that do not fit the images: what is wrong, the likely
// cause, and what was done.
std::vector<Finding> sensor_findings(const imu::SensorPlan& plan);

}  // namespace divemesh::pipeline
