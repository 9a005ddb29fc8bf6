#pragma once

#include <cstdint>
#include <optional>

#include "worker/imu/sensor_watch.hpp"
#include "worker/types/track.hpp"

namespace divemesh::pipeline {

// The attempts to track a dive, each with another plan for its sensors: as stated, by vision alone,
// with another clock offset or fewer sensors, without the times in which a sensor contradicted the
// images. After five attempts the path is taken although further times are found to be left out;
// a dive that still asks for another clock offset or other sensors is tracked without its IMU.
//
// Where images alone lose the scene too often to confirm or refute the IMU, a last attempt uses it
// all the same: if it lets vision measure clearly more frames it is right, as no wrong prediction
// finds the scene again.
class SensorAttempts {
public:
    explicit SensorAttempts(const types::Recording& recording);

    const imu::SensorPlan& plan() const { return plan_; }
    // Takes in what came of the plan. Returns true if the dive has to be tracked again with plan().
    bool again(const imu::SensorWatch& watch, const types::Track& track);

private:
    bool try_unconfirmed(std::int64_t num_measured, std::int64_t num_frames);
    bool judge_trial(bool is_whole, std::int64_t num_measured, std::int64_t num_frames);

    imu::SensorPlan plan_;
    int num_made_ = 0;
    // While the IMU is tried unconfirmed: the plan without it, and what vision measured by that.
    std::optional<imu::SensorPlan> alone_;
    std::int64_t num_measured_alone_ = 0;
    bool tried_ = false;
};

}  // namespace divemesh::pipeline
