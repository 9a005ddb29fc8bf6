#pragma once

namespace divemesh::types {

// How well a motion between two frames is known: standard deviations along and about an axis, RMS
// over the axes. 0: exactly.
struct MotionSigma {
    double position_m = 0.0;
    double rotation_rad = 0.0;
};

}  // namespace divemesh::types
