#pragma once

#include <string>
#include <vector>

#include "worker/dive/finding_log.hpp"
#include "worker/types/recording.hpp"

namespace divemesh::dive {

// Leaves out rows in which a sensor or its bus has hung and all six readings repeat those of the
// row before: at least ten of them over 100 ms, which noise makes impossible. The first row of such
// a run stays. Reports it. Changes nothing if most rows repeat: those readings were made up.
void leave_out_frozen_readings(std::vector<types::ImuSample>& samples,
                               const std::string& file,
                               FindingLog& findings);

}  // namespace divemesh::dive
