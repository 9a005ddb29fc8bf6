#pragma once

#include <cstdint>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <vector>

#include "worker/camera/image_rectifier.hpp"
#include "worker/types/keyframe.hpp"
#include "worker/types/recording.hpp"
#include "worker/types/rectified_rig.hpp"
#include "worker/types/rig.hpp"

namespace divemesh::camera {

// Returns the rig of rectified images: the widest field of view that both cameras share, without
// the fixed pattern. Throws Error{BadData} if the right camera is not on the right, or the fields
// of view hardly overlap.
types::RectifiedRig rectified_rig(const types::Rig& rig, const cv::Mat& fixed_pattern = {});

// Returns what rectifies the left images of a recording alone, as Rectifier does, in half the time.
// Throws as rectified_rig does. `num_threads`: of ImageRectifier.
ImageRectifier left_rectifier(const types::Recording& recording, int num_threads = 0);

// The rectification of a pair: undistorts both images and rotates them into one plane (Bouguet's
// method, as OpenCV's stereoRectify). The constructor throws as rectified_rig does, and works on
// `num_threads` threads (0: all cores). Each frame gets `fixed_pattern`
// (Recording::fixed_pattern()) as its rectified left image has it. Right images taken after a turn
// of the rig are rectified with it. Thread-safe after construction.
class Rectifier {
public:
    explicit Rectifier(const types::Rig& rig,
                       const cv::Mat& fixed_pattern = {},
                       int num_threads = 0);
    explicit Rectifier(const types::Recording& recording, int num_threads = 0)
        : Rectifier(recording.rig(), recording.fixed_pattern(), num_threads) {}

    const types::RectifiedRig& rig() const { return rig_; }
    // Returns the correction by range of the rectified pairs; nullptr without a port.
    const std::shared_ptr<const types::RangeTable>& ranges() const { return ranges_; }
    types::RectifiedFrame rectify(const types::StereoFrame& frame) const;
    // Returns the rectified left image; any number of channels.
    cv::Mat rectify_left(const cv::Mat& image) const { return left_.rectify(image); }

private:
    struct Turned {
        std::int64_t from_ns = 0;
        ImageRectifier right;
    };
    const ImageRectifier& right_at(std::int64_t timestamp_ns) const;

    types::RectifiedRig rig_;
    ImageRectifier left_;
    ImageRectifier right_;
    std::vector<Turned> turned_;  // ascending
    cv::Mat fixed_pattern_;
    std::shared_ptr<const types::RangeTable> ranges_;
};

}  // namespace divemesh::camera
