#pragma once

#include "worker/types/rectified_rig.hpp"
#include "worker/types/stereo_match.hpp"

namespace divemesh::calibration {

// Returns the largest set of matches whose row offsets (right minus left) are a linear function of
// the pixel, within 0.4 % of the height (RANSAC, Fischler and Bolles 1981). A wrong pitch, roll or
// focal length of the right camera causes such offsets, to first order.
types::StereoMatches agreeing_rows(const types::RectifiedRig& rig,
                                   const types::StereoMatches& matches);

}  // namespace divemesh::calibration
