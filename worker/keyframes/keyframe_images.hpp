#pragma once

#include <filesystem>
#include <functional>
#include <opencv2/core/mat.hpp>
#include <vector>

#include "worker/base/observer.hpp"
#include "worker/types/keyframe.hpp"
#include "worker/types/rectified_rig.hpp"

namespace divemesh::keyframes {

inline constexpr int kImageWidth_px = 320;

// Returns the rectified left image of a frame, CV_8UC3, whole or reduced to kImageWidth_px of
// width. Must be thread-safe.
using ReadImage = std::function<cv::Mat(int frame_index)>;

// Writes keyframes.json (poses of the rectified left camera, its focal length, file names) and
// keyframes/NNNNNN.jpg, the images 320 px wide, into `folder`. Calls `progress` every few images
// with the fraction done, 0 to 1.
void write_keyframe_images(const std::filesystem::path& folder,
                           const types::RectifiedRig& rig,
                           const std::vector<types::Keyframe>& keyframes,
                           const ReadImage& read,
                           int num_threads,
                           const base::ProgressCallback& progress);

}  // namespace divemesh::keyframes
