#pragma once

#include <apriltag/apriltag.h>
#include <memory>

#include "worker/dive/marker_family.hpp"

namespace divemesh::markers {

// A family as the AprilTag library represents it, with the function that frees it.
using AprilTagFamily = std::unique_ptr<apriltag_family_t, void (*)(apriltag_family_t*)>;
AprilTagFamily make_april_tag_family(dive::MarkerFamily family);

}  // namespace divemesh::markers
