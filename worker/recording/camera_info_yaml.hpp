#pragma once

#include <yaml-cpp/yaml.h>

#include "worker/recording/messages.hpp"

namespace divemesh::recording {

// Reads a calibration of one camera as ROS's camera_calibration_parsers write it. Throws
// Error{BadData} with the reason, and YAML::Exception.
CameraInfo read_camera_info_yaml(const YAML::Node& root, const std::string& file);

}  // namespace divemesh::recording
