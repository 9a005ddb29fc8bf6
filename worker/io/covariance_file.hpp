#pragma once

#include <filesystem>

#include "worker/types/pose_covariance.hpp"

namespace divemesh::io {

// CSV, one row a pose: timestamp_ns, the six entries xx xy xz yy yz zz of the position's covariance
// (m^2), then those of the rotation's (rad^2); relative to the first pose, in its body's axes.
// No row when they are not known.
void write_covariances(const std::filesystem::path& file,
                       const types::CovarianceTrack& covariances);
// What was written. Throws Error{NotFound}, or Error{BadData} that names the line that is wrong.
types::CovarianceTrack read_covariances(const std::filesystem::path& file);

}  // namespace divemesh::io
