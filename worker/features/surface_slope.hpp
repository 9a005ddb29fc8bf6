#pragma once

#include "worker/types/feature.hpp"
#include "worker/types/keyframe.hpp"
#include "worker/types/recording.hpp"
#include "worker/types/rectified_rig.hpp"

namespace divemesh::features {

// Sets the disparity slope of new features (on whole pixels, with depth). The disparity around each
// is taken as linear, and its slope is fitted to both images by least squares with gain and bias
//
//     a R(u + x - d - g_x x - g_y y, v + y) + b = L(u + x, v + y)
//
// (Gauss-Newton over the patch), with a prior around a surface that faces the camera; its standard
// deviation is a slant of 45 degrees.
void measure_slopes(const types::RectifiedRig& rig,
                    const types::RectifiedFrame& frame,
                    types::Features& features);

}  // namespace divemesh::features
