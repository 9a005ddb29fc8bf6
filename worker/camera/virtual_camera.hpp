#pragma once

#include <Eigen/Geometry>

#include "worker/types/rig.hpp"

namespace divemesh::camera {

// Turns a camera behind a port, whose origin is its lens, into the virtual one in the water that
// the pipeline uses: the origin becomes the point nearest to the rays in the water of all pixels
// (least squares), so that they differ as little as possible from those of a pinhole (Luczynski,
// Pfingsthorn and Birk, "The Pinax-model for accurate and efficient refraction correction of
// underwater cameras in flat-pane housings", 2017). `T_body_cam` moves with it. `water_index` is
// used if the port does not state one. A camera without a port stays.
void move_into_water(types::Camera& camera, Eigen::Isometry3d& T_body_cam, double water_index);

// Returns true if a camera of the rig is behind a port.
bool has_port(const types::Rig& rig);

// Returns the rig with another reference depth of its ports.
types::Rig with_reference_depth(types::Rig rig, double depth_m);

}  // namespace divemesh::camera
