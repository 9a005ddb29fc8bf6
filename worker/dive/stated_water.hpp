#pragma once

#include "worker/dive/dive.hpp"
#include "worker/dive/finding_log.hpp"

namespace divemesh::dive {

// Returns the refractive index of the water that dive.json states by temperature and salinity. If
// it does not, or not within what water has, that of a sea of 10 degrees, with a warning.
double index_of_water(const DiveInfo& info, FindingLog& findings);

}  // namespace divemesh::dive
