#pragma once

#include "worker/types/feature.hpp"
#include "worker/types/keyframe.hpp"
#include "worker/types/recording.hpp"
#include "worker/types/rectified_rig.hpp"

namespace divemesh::features {

// How the surface under fresh features, on whole pixels and with depth, leans: the disparity around
// each taken for linear, its slope fitted to both pictures by least squares under gain and bias
//
//     a R(u + x - d - g_x x - g_y y, v + y) + b = L(u + x, v + y)
//
// (Gauss-Newton over the patch), with a prior about a surface that faces the camera, as wide as
// leaning by 45 degrees.
void measure_slopes(const types::RectifiedRig& rig,
                    const types::RectifiedFrame& frame,
                    types::Features& features);

}  // namespace divemesh::features
