#pragma once

#include "worker/dive/dive_contents.hpp"
#include "worker/dive/finding_log.hpp"

namespace divemesh::dive {

// Reports sensors that do not cover the time of the frames, and frames that pause.
void check_coverage(const DiveContents& contents, FindingLog& findings);

}  // namespace divemesh::dive
