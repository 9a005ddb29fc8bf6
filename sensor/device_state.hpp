#pragma once

#include <filesystem>
#include <optional>

namespace divemesh::sensor {

// Returns the battery level, 0 to 1; nullopt if it is unknown. `file` holds a percentage, as
// /sys/class/power_supply/*/capacity does; "" means the first battery there.
std::optional<double> battery_level(const std::filesystem::path& file);

// Returns the signal strength of the wireless network; nullopt if there is none.
std::optional<double> link_rssi_dbm(const std::filesystem::path& file = "/proc/net/wireless");

}  // namespace divemesh::sensor
