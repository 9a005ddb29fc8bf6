#pragma once

#include "worker/dive/dive_contents.hpp"
#include "worker/dive/finding_log.hpp"

namespace divemesh::dive {

// Reports an accelerometer that says the cameras are upside down; its sign is probably reversed.
// Cannot decide for a camera that looks straight up or down.
void check_gravity_direction(const DiveContents& contents, FindingLog& findings);

}  // namespace divemesh::dive
