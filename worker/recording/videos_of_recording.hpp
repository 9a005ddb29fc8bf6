#pragma once

#include <filesystem>
#include <string_view>

#include "worker/base/observer.hpp"
#include "worker/recording/import_video.hpp"

namespace divemesh::recording {

// Returns whether a name is that of a video of a format that is read, by its extension.
bool is_video_name(std::string_view name);

// Returns the videos of the left and of the right camera in a folder or an archive, told apart by
// their names as find_camera_sides() tells images, and the calibration that lies beside them.
// Those of an archive are written into `scratch`, under names of their own. Throws Error{BadData}
// if there is not one video of each camera, or no calibration, and as ImageFolders and
// find_camera_sides() do.
VideoImportOptions videos_of_recording(const std::filesystem::path& recording,
                                       const std::filesystem::path& scratch,
                                       const base::ProgressCallback& progress);

}  // namespace divemesh::recording
