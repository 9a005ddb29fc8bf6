#pragma once

#include "worker/dive/dive_contents.hpp"
#include "worker/dive/finding_log.hpp"

namespace divemesh::dive {

// Reports sensors and ground truth that do not cover the time of the frames, and frames that pause.
// Leaves out those of another time.
void check_coverage(DiveContents& contents, FindingLog& findings);

}  // namespace divemesh::dive
