#pragma once

#include <string>
#include <vector>

#include "worker/dive/dive_files.hpp"
#include "worker/dive/finding_log.hpp"
#include "worker/dive/frame_list.hpp"

namespace divemesh::dive {

// Replaces names of images that are not there by those of files in the camera's folder that differ
// only in case, in the folder or in the extension, which may be missing in the list. Reports how
// many.
void complete_image_names(std::vector<CameraRow>& rows,
                          const DiveFiles& files,
                          const std::string& camera,
                          FindingLog& findings);

// Returns a row for each image of a camera that is named by its timestamp in nanoseconds, for
// recordings without a list. Reports that; empty if there is no such image.
std::vector<CameraRow> rows_by_image_names(const DiveFiles& files,
                                           const std::string& camera,
                                           FindingLog& findings);

}  // namespace divemesh::dive
