#pragma once

#include <filesystem>
#include <optional>

namespace divemesh::sensor {

// What the machine says of its battery, 0 to 1: `file` holds a percentage, as
// /sys/class/power_supply/*/capacity does; without one the first battery there. Nothing where that
// is not known.
std::optional<double> battery_level(const std::filesystem::path& file);

// Of the wireless network, where there is one.
std::optional<double> link_rssi_dbm(const std::filesystem::path& file = "/proc/net/wireless");

}  // namespace divemesh::sensor
