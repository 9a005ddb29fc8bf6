#include "worker/recording/calibrations_beside.hpp"

#include <algorithm>
#include <array>
#include <string>
#include <utility>

#include "worker/dive/entry_name.hpp"
#include "worker/dive/sensor_yaml.hpp"

namespace divemesh::recording {
namespace {

constexpr std::array kExtensions = {".yaml", ".yml", ".json", ".xml", ".npz", ".mat", ".txt"};

}  // namespace

std::vector<CalibrationText> calibrations_beside(const ImageFolders& folders,
                                                 dive::FindingLog& findings) {
    std::vector<CalibrationText> files;
    std::string told;
    for (const std::string& name : folders.names()) {
        const std::string lower = lower_case(name);
        const auto ends = [&](const char* extension) { return lower.ends_with(extension); };
        if (std::none_of(kExtensions.begin(), kExtensions.end(), ends)) continue;
        if (folders.size_bytes(name) > dive::kMaxYamlBytes) continue;
        std::string bytes = folders.read(name, dive::kMaxYamlBytes);
        if (!is_calibration(bytes)) continue;
        told += (told.empty() ? "" : ", ") + dive::printable(name);
        files.push_back({name, std::move(bytes)});
    }
    if (!files.empty())
        findings.info("calibration_found",
                      dive::printable(files.front().name),
                      "the calibration is that of " + told);
    return files;
}

}  // namespace divemesh::recording
