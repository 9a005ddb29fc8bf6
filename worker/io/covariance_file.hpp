#pragma once

#include <filesystem>

#include "worker/types/pose_covariance.hpp"

namespace divemesh::io {

// Writes a CSV file with one row per pose: timestamp_ns, the six entries xx xy xz yy yz zz of the
// position's covariance (m^2), then those of the rotation's (rad^2); relative to the first pose, in
// the axes of its body. Without rows if the covariances are unknown.
void write_covariances(const std::filesystem::path& file,
                       const types::CovarianceTrack& covariances);
// Reads such a file. Throws Error{NotFound}, or Error{BadData} that names the bad line.
types::CovarianceTrack read_covariances(const std::filesystem::path& file);

}  // namespace divemesh::io
