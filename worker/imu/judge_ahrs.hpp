#pragma once

#include <vector>

#include "worker/imu/judge_gyroscope.hpp"
#include "worker/types/recording.hpp"

namespace divemesh::imu {

// The cause of a contradiction between AHRS and vision.
enum class AhrsFault {
    None,
    Inverse,     // the quaternions map the world to the body
    ScalarLast,  // w is written last
    AsGyroscope  // as stated in `rotation`
};

struct AhrsJudgement {
    AhrsFault fault = AhrsFault::None;
    GyroscopeJudgement rotation;  // of the first time that contradicts
    // Without a fault of the whole: the times in which it contradicts vision.
    std::vector<types::TimeInterval> wrong_times;
};

// Compares the rotations of the AHRS with those of vision over the whole dive, in parts of 40
// spans, each as judge_gyroscope() does. The AHRS contradicts vision if more parts contradict than
// fit. Otherwise the times in which it contradicts vision are found as wrong_times() does for a
// gyroscope.
AhrsJudgement judge_ahrs(const std::vector<types::OrientationSample>& orientations,
                         const std::vector<RotationSpan>& spans);

}  // namespace divemesh::imu
