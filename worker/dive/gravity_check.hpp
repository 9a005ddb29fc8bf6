#pragma once

#include "worker/dive/dive_contents.hpp"
#include "worker/dive/finding_log.hpp"

namespace divemesh::dive {

// Reports an accelerometer by which the cameras hang upside down: more likely its sign is reversed.
// A camera that looks straight up or down cannot tell.
void check_gravity_direction(const DiveContents& contents, FindingLog& findings);

}  // namespace divemesh::dive
