#pragma once

#include <string_view>

#include "worker/recording/calibration_parts.hpp"

namespace divemesh::recording {

// Reads the cameras of COLMAP's cameras.txt in the order of their numbers. Their principal points
// become those of pixels whose centres are at integers. Throws Error{BadData} with the line if it
// is not such a list, has not two cameras, or a model that is not read.
CalibrationParts read_colmap_cameras(std::string_view text, const std::string& file);

}  // namespace divemesh::recording
