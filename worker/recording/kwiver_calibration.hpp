#pragma once

#include <yaml-cpp/yaml.h>

#include "worker/recording/calibration_parts.hpp"

namespace divemesh::recording {

// Reads the stereo calibration that KWIVER and VIAME write as JSON: numbers fx_left, k1_left ... of
// OpenCV's models, and T and R that map points of the left camera to the right one. Throws
// Error{BadData} with the reason, and YAML::Exception.
CalibrationParts read_kwiver_calibration(const YAML::Node& root,
                                         const std::string& file,
                                         const RigHints& hints,
                                         dive::FindingLog& findings);

}  // namespace divemesh::recording
