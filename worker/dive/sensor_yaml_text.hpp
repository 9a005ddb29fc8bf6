#pragma once

#include <optional>
#include <string>

#include "worker/dive/sensor_yaml.hpp"

namespace divemesh::dive {

// What a sensor.yaml says for its readers beside the calibration.
struct SensorYamlNotes {
    std::string comment;  // one line
    std::optional<double> rate_hz = std::nullopt;
    int digits = 0;  // significant digits of numbers; 0: as many as give exactly the same number
};

// Return the text of a sensor.yaml in EuRoC's layout, of a camera, an IMU and of any other sensor,
// of which T_BS alone is written. T_BS is the identity where it is missing; other values that are
// missing are left out.
std::string camera_yaml_text(const SensorYaml& yaml, const SensorYamlNotes& notes);
std::string imu_yaml_text(const SensorYaml& yaml, const SensorYamlNotes& notes);
std::string sensor_yaml_text(const std::string& type,
                             const SensorYaml& yaml,
                             const SensorYamlNotes& notes);

}  // namespace divemesh::dive
