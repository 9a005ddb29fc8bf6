#pragma once

#include <functional>
#include <opencv2/core/mat.hpp>
#include <optional>

#include "worker/dive/finding_log.hpp"
#include "worker/dive/frame_reader.hpp"

namespace divemesh::dive {

// Looks at some frames spread over the dive and reports what a camera or its recorder did to all
// images: one of the pair less sharp, interlaced lines, a Bayer mosaic, no texture, a fixed
// pattern. `share_matching` is the share of the left corners that the right images match; nullopt:
// too few to tell. `load` is called on other threads. Returns the mask of fixed patterns in left
// images, empty without any.
cv::Mat check_images(int num_frames,
                     const std::function<LoadedPair(int index)>& load,
                     std::optional<double> share_matching,
                     FindingLog& findings);

}  // namespace divemesh::dive
