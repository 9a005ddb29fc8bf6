#pragma once

#include <string>
#include <vector>

#include "worker/dive/finding_log.hpp"
#include "worker/types/recording.hpp"

namespace divemesh::dive {

// Leaves out the rows whose rate of rotation stops at the end of the gyroscope's range, and those
// whose acceleration does if they are few, each with the rows around it, so that no motion is
// integrated across the gap. Reports both; an accelerometer with many is left to the tracking,
// which uses its gyroscope alone.
void leave_out_clipped_readings(std::vector<types::ImuSample>& samples,
                                const std::string& file,
                                FindingLog& findings);

}  // namespace divemesh::dive
