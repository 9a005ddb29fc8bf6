#pragma once

#include <vector>

#include "worker/types/breaks.hpp"
#include "worker/types/recording.hpp"

namespace divemesh::imu {

// The cause of a contradiction between pressure sensor and vision.
enum class PressureFault {
    None,
    Unexplained,  // another dive's readings, another clock, or a blocked port
    Reversed,     // counts upwards
    Scaled,       // `scale`: wrong units, or of density
    Held,         // `held_share` of the readings stay at one end: the range is exceeded
    Stepped,      // its zero moved by `step_m` at once
};

struct PressureJudgement {
    PressureFault fault = PressureFault::None;
    double scale = 1.0;       // of depths by pressure over those by vision
    double error_m = 0.0;     // RMS of the changes of depth that the scale does not explain
    double held_share = 0.0;  // of the readings
    double step_m = 0.0;      // the largest
};

// Compares the changes of depth over five seconds by pressure and by vision. Least squares over
//
//     change of depth = s (-change of z) + a (change of x) + b (change of y)
//
// where a and b, the tilt of the path, have a prior: small where another sensor measures the
// vertical. The sensor contradicts vision if s is not 1 or if the changes do not fit whatever s is;
// waves above and a scale that the cameras do not know well are no contradiction. A dive with
// hardly any change of depth is not judged. The tenth of the changes that fits worst is set aside,
// so that single wrong readings do no harm. What the fit leaves of the depths must not step: their
// medians over five half seconds with readings before and after a time differ by less than 0.2 m,
// or by less than eight times what they usually do where waves pass above, or do not last.
PressureJudgement judge_pressure(const std::vector<types::PressureSample>& pressure,
                                 const types::Trajectory& trajectory,
                                 const types::Breaks& breaks_ns,
                                 bool vertical_is_known);

}  // namespace divemesh::imu
