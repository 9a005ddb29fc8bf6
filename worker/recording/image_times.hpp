#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "worker/base/observer.hpp"
#include "worker/dive/finding_log.hpp"
#include "worker/dive/frame_list.hpp"
#include "worker/recording/camera_sides.hpp"
#include "worker/recording/image_folders.hpp"
#include "worker/recording/stamp_unit.hpp"

namespace divemesh::recording {

// What a user says about the times of images.
struct TimeOptions {
    std::filesystem::path list;     // a table of times and names; "": the one beside the images
    std::optional<double> rate_hz;  // the names count images of this rate
    std::optional<StampUnit> unit;  // of times in the table or the names
};

// The images of both cameras with their times, in the order of time.
struct ImageTimes {
    std::vector<dive::CameraRow> left;
    std::vector<dive::CameraRow> right;
    std::string source;          // for people: "the times in the names (nanoseconds)"
    bool is_in_seconds = false;  // whole seconds, so images of one second are spread over it
};

// Returns when the images were taken: by a list, by their names, by their EXIF, or by counting them
// at the stated rate. Images without a time are left out with a warning. Throws
// Error{InvalidArgument} that says what to state if there is no time.
ImageTimes find_image_times(const ImageFolders& folders,
                            const CameraSides& sides,
                            const TimeOptions& options,
                            dive::FindingLog& findings,
                            const base::ProgressCallback& progress);

}  // namespace divemesh::recording
