#pragma once

#include <yaml-cpp/yaml.h>

#include "worker/recording/calibration_parts.hpp"

namespace divemesh::recording {

// Reads what a file of OpenCV's calibration states, by the names that its samples and users give:
// M1 D1 M2 D2 or K_left, cameraMatrixL, distCoeffs1 ... of two cameras, camera_matrix of one, R and
// T that map points of the left camera to the right one. Returns nullopt if it states none of them.
// Throws Error{BadData} with the reason, and YAML::Exception.
std::optional<CalibrationParts> read_opencv_calibration(const YAML::Node& root,
                                                        const std::string& file,
                                                        const RigHints& hints,
                                                        dive::FindingLog& findings);

}  // namespace divemesh::recording
