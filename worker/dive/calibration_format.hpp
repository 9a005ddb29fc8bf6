#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace divemesh::dive {

// The programs whose calibrations are told apart.
enum class CalibrationProgram { Kalibr, OpenCv, Ros, Kwiver, Colmap };

// A calibration in the format of another tool.
struct CalibrationFormat {
    CalibrationProgram program;
    std::string name;
    std::string remedy;  // how to make a sensor.yaml of it
};

// Recognises calibrations of Kalibr, OpenCV, ROS, KWIVER and COLMAP by what they hold; nullopt for
// a sensor.yaml.
std::optional<CalibrationFormat> foreign_calibration(std::string_view text);

}  // namespace divemesh::dive
