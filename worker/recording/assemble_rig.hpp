#pragma once

#include "worker/recording/calibration_parts.hpp"

namespace divemesh::recording {

// Returns the rig that consists of the parts. Throws Error{BadData} with what is missing, what
// contradicts itself and what to do.
RigFiles assemble_rig(const CalibrationParts& parts,
                      const RigHints& hints,
                      dive::FindingLog& findings);

}  // namespace divemesh::recording
