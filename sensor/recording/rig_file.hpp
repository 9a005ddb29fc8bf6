#pragma once

#include <filesystem>
#include <optional>

#include "worker/types/rig.hpp"

namespace divemesh::sensor {

// What cam0/sensor.yaml and cam1/sensor.yaml say; the body is cam0. Nothing when one is not there
// or cannot be used.
std::optional<types::Rig> read_rig(const std::filesystem::path& dive_root);

}  // namespace divemesh::sensor
