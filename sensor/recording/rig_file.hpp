#pragma once

#include <filesystem>
#include <optional>

#include "worker/types/rig.hpp"

namespace divemesh::sensor {

// Reads cam0/sensor.yaml and cam1/sensor.yaml; the body is cam0. Returns nullopt if one is missing
// or unusable.
std::optional<types::Rig> read_rig(const std::filesystem::path& dive_root);

}  // namespace divemesh::sensor
