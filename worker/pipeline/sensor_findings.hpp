#pragma once

#include <optional>
#include <vector>

#include "schemas/finding.hpp"
#include "worker/imu/judge_pressure.hpp"
#include "worker/imu/sensor_watch.hpp"
#include "worker/types/recording.hpp"

namespace divemesh::pipeline {

// Return the findings about sensors that do not fit the images: what is wrong, the likely cause,
// and what was done.
std::vector<Finding> sensor_findings(const imu::SensorPlan& plan);
Finding pressure_left_out(const imu::PressureJudgement& judgement);
// Says that the samples have more noise than `stated` lets expect on a diver; nullopt: they do not.
std::optional<Finding> imu_noisy(const std::vector<types::ImuSample>& samples,
                                 const types::ImuNoise& stated,
                                 bool accelerometer_used);

}  // namespace divemesh::pipeline
