#pragma once

#include <Eigen/Core>

#include "worker/camera/rectified_lens.hpp"
#include "worker/types/rectified_rig.hpp"

namespace divemesh::camera {

// Returns d(u, v)/d(distance), px/m: what must be added to a rectified pixel that was measured
// through flat glass at this distance before the lens, if the calibration was made in water and
// does not describe the glass. Through water at an angle t to the axis, and air at a with
// sin a = n sin t, a lens sees along a ray that crosses its axis at distance (1 - tan a / tan t)
// before itself (Treibitz, Schechner, Kunz and Singh, "Flat refractive geometry", 2012). A
// calibration absorbs this at its own range. At a depth Z what is left is, but for a shift along
// the axis that all pixels share and for what focal length and distortion hold too,
//
//     distance (tan a / tan t - n) / Z      of the distance from the axis, outwards
//
// Zero where no ray passes a flat port.
Eigen::Vector2d shift_of_port(const types::RectifiedRig& rig,
                              const RectifiedLens& lens,
                              const Eigen::Vector2d& rectified_px,
                              double depth_m);

}  // namespace divemesh::camera
