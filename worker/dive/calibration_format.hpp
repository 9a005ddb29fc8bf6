#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace divemesh::dive {

// A calibration in the format of another tool.
struct CalibrationFormat {
    std::string name;
    std::string remedy;  // how to write it as a sensor.yaml
};

// Recognises calibrations of Kalibr, OpenCV and ROS by their keys; nullopt for a sensor.yaml.
std::optional<CalibrationFormat> foreign_calibration(std::string_view text);

}  // namespace divemesh::dive
