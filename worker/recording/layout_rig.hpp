#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "worker/dive/finding_log.hpp"
#include "worker/recording/calibration_parts.hpp"
#include "worker/recording/camera_sides.hpp"
#include "worker/recording/image_folders.hpp"
#include "worker/recording/kitti_calibration.hpp"
#include "worker/recording/rig_files.hpp"

namespace divemesh::recording {

// Returns the folder that holds cam0 and cam1 in EuRoC's layout, "mav0/" with the slash; nullopt
// for another layout.
std::optional<std::string> euroc_folder(const CameraSides& sides);

// Returns the calibration that lies beside the images: sensor.yaml of EuRoC's layout below `root`,
// KITTI's calib.txt or calib_cam_to_cam.txt, or files that rig_of_texts() reads. Throws
// Error{BadData} that says what to do if there is none, and as they do.
RigFiles rig_of_layout(const std::filesystem::path& root,
                       const ImageFolders& folders,
                       const CameraSides& sides,
                       const RigHints& hints,
                       dive::FindingLog& findings);

}  // namespace divemesh::recording
