#pragma once

#include <vector>

#include "schemas/finding.hpp"
#include "worker/imu/judge_pressure.hpp"
#include "worker/imu/sensor_watch.hpp"

namespace divemesh::pipeline {

// Return the findings about sensors that do not fit the images: what is wrong, the likely cause,
// and what was done.
std::vector<Finding> sensor_findings(const imu::SensorPlan& plan);
Finding pressure_left_out(const imu::PressureJudgement& judgement);

}  // namespace divemesh::pipeline
