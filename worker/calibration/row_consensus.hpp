#pragma once

#include "worker/types/rectified_rig.hpp"
#include "worker/types/stereo_match.hpp"

namespace divemesh::calibration {

// Returns the largest set of matches whose row offsets right minus left are one linear function of
// the pixel, within 0.4 % of the height (RANSAC, Fischler and Bolles 1981): to first order what a
// wrong pitch, roll or focal length of the right camera makes of them.
types::StereoMatches agreeing_rows(const types::RectifiedRig& rig,
                                   const types::StereoMatches& matches);

}  // namespace divemesh::calibration
