#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "worker/dive/finding_log.hpp"
#include "worker/dive/frame_list.hpp"
#include "worker/recording/camera_sides.hpp"
#include "worker/recording/time_table.hpp"

namespace divemesh::recording {

// The images that a table gives times, in the order of its rows.
struct ListedImages {
    std::vector<dive::CameraRow> left;
    std::vector<dive::CameraRow> right;
};

// Returns the images of both cameras that the rows of a table name: by a name of each camera, or by
// one that both have. Names may lack the extension or be paths of another machine. A table without
// names gives times to all images in the order of their names, if it has as many rows, or to those
// whose names count its rows from 0.
ListedImages images_of_table(const TimeTable& table, const CameraSides& sides);

}  // namespace divemesh::recording
