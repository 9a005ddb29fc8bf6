#pragma once

#include <vector>

#include "worker/dive/finding_log.hpp"
#include "worker/recording/image_folders.hpp"
#include "worker/recording/read_rig.hpp"

namespace divemesh::recording {

// Returns the files of other programs' calibrations that lie among the files of a recording, by
// name, and reports that they were found.
std::vector<CalibrationText> calibrations_beside(const ImageFolders& folders,
                                                 dive::FindingLog& findings);

}  // namespace divemesh::recording
