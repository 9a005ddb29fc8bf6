#pragma once

#include "worker/types/rectified_rig.hpp"

namespace divemesh::synthetic {

// Returns an ideal stereo pair with a baseline of 12 cm and the principal point at the image
// centre.
inline types::RectifiedRig ideal_rig(int width_px, int height_px, double focal_px) {
    types::RectifiedRig rig;
    rig.width_px = width_px;
    rig.height_px = height_px;
    rig.focal_px = focal_px;
    rig.cx_px = 0.5 * (width_px - 1);
    rig.cy_px = 0.5 * (height_px - 1);
    rig.baseline_m = 0.12;
    return rig;
}

}  // namespace divemesh::synthetic
