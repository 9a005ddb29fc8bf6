#pragma once

#include <cstdint>

#include "worker/types/rig.hpp"

namespace divemesh::simulator {

// A calibration as it is written down: what its file states of the rig, and by how much the clock
// of the IMU differs from that of the cameras without the file saying so.
struct StatedRig {
    types::Rig rig;
    std::int64_t imu_clock_offset_ns = 0;  // t_imu = t_cam + offset
};

// Returns a calibration of `rig` that is wrong by errors drawn by seed, each normal with a standard
// deviation of `times` that of a typical calibration: focal length 0.15 %, principal point 1 px (of
// a camera of 640 px), k1 3 %, cameras against each other 0.03 degrees about each axis, baseline
// 0.2 %, cameras against IMU 0.25 degrees about each axis and 4 ms. The same seed draws the same
// errors, `times` as large.
StatedRig draw_calibration_error(const types::Rig& rig, double times, std::uint64_t seed);

// Returns a calibration that has the right camera pitched by so much that images rectified with it
// are out of line by `misalignment_px` in the centre.
types::Rig pitch_right_camera(types::Rig rig, double misalignment_px);

}  // namespace divemesh::simulator
