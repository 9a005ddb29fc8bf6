#pragma once

#include <string>
#include <vector>

#include "worker/dive/finding_log.hpp"
#include "worker/types/recording.hpp"

namespace divemesh::dive {

// Replaces readings that a recorder filled with zeros. Recorders do so when they receive gyroscope
// and accelerometer at different times. A row without a rate is left out. A missing acceleration is
// interpolated linearly between readings at most 50 ms apart; without them its row is left out. An
// acceleration of exactly zero cannot be, as it includes gravity. A rate of exactly zero is missing
// if the rows around it rotate. Reports what it found; changes nothing if no row has an
// acceleration.
void fill_zero_readings(std::vector<types::ImuSample>& samples,
                        const std::string& file,
                        FindingLog& findings);

}  // namespace divemesh::dive
