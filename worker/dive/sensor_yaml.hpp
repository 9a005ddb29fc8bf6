#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "worker/dive/finding_log.hpp"
#include "worker/dive/port_yaml.hpp"
#include "worker/types/rig.hpp"

namespace divemesh::dive {

constexpr std::int64_t kMaxYamlBytes = std::int64_t{1} << 20;

// A sensor.yaml as written, not validated; missing fields are empty.
struct SensorYaml {
    std::optional<Eigen::Matrix4d> T_body_sensor;  // T_BS
    std::string camera_model;
    std::string distortion_model;
    std::vector<double> intrinsics;  // as Kalibr orders them, of a pinhole fu fv cu cv
    std::vector<double> distortion_coefficients;
    std::vector<double> resolution;
    std::optional<PortYaml> port;
    std::optional<double> gyroscope_noise_density;
    std::optional<double> gyroscope_random_walk;
    std::optional<double> accelerometer_noise_density;
    std::optional<double> accelerometer_random_walk;
    std::string position_kind;             // `kind`: gps_float, usbl or surface_fix
    std::optional<double> epsg;            // of positions
    std::optional<double> offset_sigma_m;  // of an offset that all positions share
};

// Parses a sensor.yaml. Returns nullopt, with an error `calibration_unreadable` that gives the
// line, if it is not YAML of this kind. Aliases, anchors and deep nesting are rejected before any
// object is built.
std::optional<SensorYaml> parse_sensor_yaml(std::string_view text,
                                            const std::string& file,
                                            FindingLog& findings);

}  // namespace divemesh::dive
