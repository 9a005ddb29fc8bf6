#pragma once

#include <opencv2/core/types.hpp>
#include <vector>

#include "worker/boards/board_recording.hpp"

namespace divemesh::board_calibration {

// Returns at most `max_views` of the views, in the order of time: each time that which adds most
// to the cells of both images, to the distances and to the tilts that were seen before.
std::vector<boards::BoardView> pick_views(const boards::Board& board,
                                          const std::vector<boards::BoardView>& views,
                                          cv::Size left_size,
                                          cv::Size right_size,
                                          std::size_t max_views);

}  // namespace divemesh::board_calibration
