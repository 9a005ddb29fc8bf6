#pragma once

#include <string>
#include <vector>

#include "worker/dive/finding_log.hpp"
#include "worker/dive/frame_list.hpp"
#include "worker/recording/image_times.hpp"

namespace divemesh::recording {

// The images of both cameras by one clock, in the order of time.
struct PairedImages {
    std::vector<dive::CameraRow> left;
    std::vector<dive::CameraRow> right;
};

// Takes off the constant difference of the cameras' clocks that gives most images a partner, if
// their times do not agree. Times of whole seconds say only which images belong together: the right
// image of a pair gets the time of the left one, and images without a partner are left out. Reports
// how the pairs were made. Throws Error{BadData} if there are none.
PairedImages pair_images(ImageTimes times, dive::FindingLog& findings);

}  // namespace divemesh::recording
