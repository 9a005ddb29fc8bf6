#pragma once

#include <opencv2/core/mat.hpp>

#include "worker/camera/image_rectifier.hpp"
#include "worker/types/recording.hpp"

namespace divemesh::camera {

// Rectified left images at a small size. A JPEG is decoded at a half, quarter or eighth, then
// rectified at the small size. Thread-safe after construction.
class SmallLeftImages {
public:
    // `left`: the lens of the recording, as stated or refined; `rig`: of its rectified images,
    // which are reduced to `width_px` unless they are as small; `num_threads`: of the constructor,
    // 0: all cores. `recording` must outlive it.
    SmallLeftImages(const types::Recording& recording,
                    const RectifiedLens& left,
                    const types::RectifiedRig& rig,
                    int width_px,
                    int num_threads = 0);

    // Returns the left image of a frame, CV_8UC3; throws as Recording::left_in_color() does.
    cv::Mat read(int frame_index) const;

private:
    const types::Recording& recording_;
    int reduction_;  // of the decoded images, which are at least as wide as the small ones
    ImageRectifier rectifier_;
};

}  // namespace divemesh::camera
