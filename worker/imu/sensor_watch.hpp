#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "worker/imu/inertial_prior.hpp"
#include "worker/imu/judge_accelerometer.hpp"
#include "worker/imu/judge_ahrs.hpp"
#include "worker/imu/judge_gyroscope.hpp"
#include "worker/types/imu_alignment.hpp"
#include "worker/types/recording.hpp"
#include "worker/types/sensors_left_out.hpp"

namespace divemesh::imu {

// How the sensors of a dive are used while it is tracked.
struct SensorPlan {
    types::SensorsLeftOut left_out;
    types::ImuAlignment alignment;            // with which tracking starts
    std::size_t num_alignment_rotations = 0;  // that told it; 0: stated, or by correlation
    // The scene was lost before vision confirmed the IMU: vision works alone until it does.
    bool imu_unconfirmed = false;
    bool imu_confirmed = false;    // by an earlier attempt: it stays in use when the scene is lost
    bool imu_unsettled = false;    // left out, as every attempt asked for another plan
    GyroscopeJudgement gyroscope;  // why the plan differs from the dive as stated
    bool accelerometer_clipped = false;      // known before tracking; the dive reports it
    double gravity_disagreement_m_s2 = 0.0;  // likewise, of the accelerometer
    AhrsJudgement ahrs;                      // likewise
};

// The sensors that a dive has and is to be reconstructed with.
struct SensorsUsed {
    bool imu = false;
    bool ahrs = false;
};

// A watch over the sensors while a dive is tracked. It compares them with motions that vision alone
// measured and decides when the dive has to be tracked again with another plan: a clock offset that
// tracking cannot correct by itself, a sensor that contradicts the images, or an IMU that was left
// out and fits after all.
class SensorWatch {
public:
    SensorWatch(const types::Recording& recording, const SensorsUsed& used, const SensorPlan& plan);

    // Takes in a motion measured by vision alone. Leaves the IMU out of `inertial` for the time in
    // which it contradicts vision.
    void watch(const VisionMotion& motion, InertialPrior& inertial);
    // Takes in the alignment that is used from now on, and how many rotations told it. The dive
    // starts again if the error of the offset so far was too large to be corrected while it is
    // tracked.
    void aligned(const types::ImuAlignment& alignment, std::size_t num_rotations);
    // Takes in that vision contradicts the IMU between two frames.
    void contradicted_in(const types::TimeInterval& time);
    // Takes in that vision lost the scene in a frame.
    void lost_scene();
    // Takes in a frame that tells nothing about the sensors, though nothing was lost.
    void passed_frame() { num_lost_ = 0; }

    // Returns the plan, with what was learnt about the sensors.
    const SensorPlan& plan() const { return plan_; }
    // Returns the plan with which to start the dive again, now.
    const std::optional<SensorPlan>& restart() const { return restart_; }
    // Returns the plan with which to start the dive again after its last frame.
    std::optional<SensorPlan> restart_at_end() const;

private:
    void judge(InertialPrior& inertial);
    void start_again(bool with_imu);
    void take(const GyroscopeJudgement& judgement, InertialPrior& inertial);
    std::vector<types::TimeInterval> wrong_times() const;
    void contradicted(const GyroscopeJudgement& judgement, InertialPrior& inertial);

    SensorPlan plan_;
    std::vector<types::ImuSample> samples_;  // as stated, with the plan's time offset
    std::vector<types::OrientationSample> orientations_;
    RotationSpans turns_;
    GravityByVision gravity_;
    std::size_t next_judgement_;
    bool confirmed_ = false;
    int num_lost_ = 0;  // frames in a row
    std::optional<SensorPlan> restart_;
    // Times in which a confirmed IMU contradicted vision, and why first.
    std::vector<types::TimeInterval> contradicted_;
    std::vector<types::TimeInterval> contradicted_frames_;  // joined where little lies between
    bool contradicts_now_ = false;
    GyroscopeJudgement first_contradiction_;
    std::size_t num_confirmed_ = 0;  // spans up to the last judgement that the IMU fits
};

}  // namespace divemesh::imu
