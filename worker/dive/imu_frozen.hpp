#pragma once

#include <string>
#include <vector>

#include "worker/dive/finding_log.hpp"
#include "worker/types/recording.hpp"

namespace divemesh::dive {

// Leaves out rows in which a sensor or its bus has hung: all six readings repeat those of the row
// before, at least ten times over 100 ms, which noise makes impossible, or those of gyroscope or
// accelerometer alone do for a second. The first row of such a run stays. Reports it. Readings that
// repeat in most rows were made up and stay.
void leave_out_frozen_readings(std::vector<types::ImuSample>& samples,
                               const std::string& file,
                               FindingLog& findings);

}  // namespace divemesh::dive
