#pragma once

#include <string>
#include <vector>

#include "worker/dive/finding_log.hpp"
#include "worker/types/recording.hpp"

namespace divemesh::dive {

// Takes off the jumps of an AHRS: turns by more than five degrees from one row to the next, ten
// times as far as usual and faster than a diver turns. A compass that is reset, or that iron
// leaves, turns its whole world; the rows after a jump are turned back in that world. A table with
// many jumps stays as it is: its rows are no orientations in their order. Reports what it does.
void take_off_ahrs_jumps(std::vector<types::OrientationSample>& samples,
                         const std::string& file,
                         FindingLog& findings);

}  // namespace divemesh::dive
