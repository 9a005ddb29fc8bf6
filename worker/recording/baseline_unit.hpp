#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>

#include "worker/dive/finding_log.hpp"

namespace divemesh::recording {

// Returns the unit of a translation between the cameras, in m: the one stated, or else the only one
// of m and mm in which it is the baseline of a rig. Throws Error{BadData} if it is in neither. A
// length that could be in cm too is taken as mm, with a warning.
double metres_per_unit(const Eigen::Vector3d& translation,
                       std::optional<double> stated,
                       const std::string& file,
                       dive::FindingLog& findings);

}  // namespace divemesh::recording
