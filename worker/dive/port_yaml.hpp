#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>
#include <yaml-cpp/yaml.h>

#include "worker/dive/finding_log.hpp"
#include "worker/types/port.hpp"

namespace divemesh::dive {

// The port of a sensor.yaml as written, not validated:
//
//     port: {type: flat, normal: [0, 0, 1], distance_m: 0.025, thickness_m: 0.006,
//     glass_index: 1.49} port: {type: dome, centre_m: [0, 0, 0], radius_m: 0.05, thickness_m:
//     0.006, glass_index: 1.49}
struct PortYaml {
    std::string type;
    std::map<std::string, std::vector<double>> numbers;  // of all other keys
};

// Returns the port that a file states; nullopt if there is no key `port`. Throws YAML::Exception,
// with the line, if it is not a map, or a value is not a number or a list of numbers.
std::optional<PortYaml> port_at(const YAML::Node& root);

// Returns the port; nullopt with an error `calibration_port` if a value is missing, unknown or not
// possible.
std::optional<types::Port> port_of(const PortYaml& yaml,
                                   const std::string& file,
                                   FindingLog& findings);

// States a port as seen from its lens; an index of the water only if it is known.
PortYaml state_port(const types::Port& port);

}  // namespace divemesh::dive
