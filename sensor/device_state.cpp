#include "sensor/device_state.hpp"

#include <fstream>
#include <sstream>
#include <string>

namespace divemesh::sensor {
namespace {

namespace fs = std::filesystem;

std::string first_word(const fs::path& file) {
    std::ifstream stream(file);
    std::string word;
    stream >> word;
    return word;
}

fs::path first_battery() {
    std::error_code ignored;
    for (const auto& entry : fs::directory_iterator("/sys/class/power_supply", ignored))
        if (first_word(entry.path() / "type") == "Battery") return entry.path() / "capacity";
    return {};
}

}  // namespace

std::optional<double> battery_level(const fs::path& file) {
    const fs::path capacity = file.empty() ? first_battery() : file;
    if (capacity.empty()) return std::nullopt;
    std::ifstream stream(capacity);
    double percent = -1.0;
    if (!(stream >> percent) || !(percent >= 0.0 && percent <= 100.0)) return std::nullopt;
    return percent / 100.0;
}

// The file has two lines of headings; then "wlan0: 0000   54.  -56.  -256 ...": status, quality,
// level, noise.
std::optional<double> link_rssi_dbm(const fs::path& file) {
    std::ifstream stream(file);
    std::string line;
    for (int i = 0; i < 3; ++i)
        if (!std::getline(stream, line)) return std::nullopt;
    std::istringstream fields(line);
    std::string interface, status;
    double quality = 0.0;
    double level = 0.0;
    if (!(fields >> interface >> status >> quality >> level)) return std::nullopt;
    if (!(level < 0.0 && level >= -200.0)) return std::nullopt;
    return level;
}

}  // namespace divemesh::sensor
