#pragma once

#include <yaml-cpp/yaml.h>

#include "worker/recording/calibration_parts.hpp"

namespace divemesh::recording {

// Reads camchain.yaml or camchain-imucam.yaml. The two cameras are those of the topics that the
// hints name, or else cam0 and cam1. Throws Error{BadData} with the reason, and YAML::Exception.
CalibrationParts read_kalibr_chain(const YAML::Node& root,
                                   const std::string& file,
                                   const RigHints& hints,
                                   dive::FindingLog& findings);

// Returns the noise that imu.yaml states, as it is given to Kalibr or as Kalibr writes it; nullopt
// for another file.
std::optional<dive::SensorYaml> read_kalibr_imu(const YAML::Node& root);

}  // namespace divemesh::recording
