#pragma once

#include <string>

#include "worker/dive/finding_log.hpp"
#include "worker/recording/dive_writer.hpp"
#include "worker/recording/image_folders.hpp"

namespace divemesh::recording {

// Adds IMU and depth of a recording in EuRoC's layout below `folder` ("mav0/"): imu0/data.csv, if
// the rig says where the IMU is, and pressure0/data.csv, with the separators, headings and units of
// times that convert_time_table() reads. Reports sensors that are left out. Throws Error{BadData}
// for a table that cannot be read.
void add_layout_sensors(const ImageFolders& folders,
                        const std::string& folder,
                        const RigFiles& rig,
                        DiveWriter& writer,
                        dive::FindingLog& findings);

}  // namespace divemesh::recording
