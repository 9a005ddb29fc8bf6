#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "worker/dive/common_clock.hpp"
#include "worker/dive/finding_log.hpp"
#include "worker/dive/sensor_yaml.hpp"
#include "worker/types/outside_positions.hpp"

namespace divemesh::dive {

// Returns the code of a coordinate system that positions may be stated in: WGS 84 as latitude and
// longitude (4326) or a zone of UTM; nullopt, with an error that names the `file`, for all others.
std::optional<int> position_system(const std::optional<double>& epsg,
                                   const std::string& file,
                                   FindingLog& findings);

// Parses mav0/position0/data.csv: timestamp [ns], latitude and longitude [deg] or easting and
// northing [m], height [m], sigma_h [m], sigma_v [m] (0: the height was not measured). `utm_m`
// holds the numbers as stated, for to_common_system().
std::vector<types::PositionSample> parse_positions(std::string_view text,
                                                   int epsg,
                                                   const std::string& file,
                                                   FindingLog& findings,
                                                   CommonClock* clock = nullptr);

// Parses mav0/velocity0/data.csv: timestamp [ns], vx, vy, vz [m/s] in the instrument's axes, sigma
// [m/s].
std::vector<types::VelocitySample> parse_velocities(std::string_view text,
                                                    const std::string& file,
                                                    FindingLog& findings,
                                                    CommonClock* clock = nullptr);

// Returns a source without samples as its sensor.yaml describes it; nullopt, with an error, if that
// lacks the kind or the coordinate system.
std::optional<types::PositionSource> describe_source(const std::string& name,
                                                     const SensorYaml& yaml,
                                                     const std::string& file,
                                                     FindingLog& findings);

// Parses control_points.json into points as stated, and their coordinate system. Every mistake is
// an error that names the point, as a wrong one would move the model.
void parse_control_points(std::string_view text,
                          types::OutsidePositions& outside,
                          FindingLog& findings);

// Converts all positions, as stated, to the UTM zone of the first of them. Places that have none in
// it are an error.
void to_common_system(types::OutsidePositions& outside, FindingLog& findings);

}  // namespace divemesh::dive
