#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "worker/recording/calibration_parts.hpp"

namespace divemesh::recording {

// Reads a calibration: the folder of a dive with sensor.yaml files, or files of Kalibr, OpenCV,
// ROS, KWIVER, Matlab and COLMAP, which together state a rig. Formats are told by what files hold,
// not by their names. Throws Error{BadData} or Error{NotFound} with the reason and what to do.
RigFiles read_rig(const std::vector<std::filesystem::path>& files,
                  dive::FindingLog& findings,
                  const RigHints& hints = {});

// A file of a calibration, as it was read.
struct CalibrationText {
    std::string name;
    std::string bytes;
};

// Returns whether a file is, by what it holds, part of a calibration that read_rig() reads.
bool is_calibration(std::string_view bytes);

// As read_rig(), of files that are in memory.
RigFiles rig_of_texts(const std::vector<CalibrationText>& files,
                      dive::FindingLog& findings,
                      const RigHints& hints = {});

// Writes the sensor.yaml files of a rig into the folder of a dive, or a new one. Throws
// Error{Conflict} if there is one already, and as base::write_file does.
void write_rig(const RigFiles& rig, const std::filesystem::path& dive);

}  // namespace divemesh::recording
