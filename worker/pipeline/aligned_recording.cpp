#include "worker/pipeline/aligned_recording.hpp"

#include "worker/camera/rectified_lens.hpp"

namespace divemesh::pipeline {
namespace {

types::Rig reduced_rig(types::Rig rig, int reduction) {
    if (reduction == 1) return rig;
    rig.cam0 = camera::reduced_camera(rig.cam0, reduction);
    rig.cam1 = camera::reduced_camera(rig.cam1, reduction);
    return rig;
}

}  // namespace

AlignedRecording::AlignedRecording(types::Recording& recording)
    : recording_(recording),
      recorded_rig_(recording.rig()),
      rig_(recorded_rig_),
      fixed_pattern_(recording.fixed_pattern()) {}

void AlignedRecording::set_rig(const types::Rig& rig) {
    recorded_rig_ = rig;
    rig_ = reduced_rig(recorded_rig_, reduction_);
}

void AlignedRecording::set_reduction(int reduction) {
    reduction_ = reduction;
    rig_ = reduced_rig(recorded_rig_, reduction_);
    fixed_pattern_ = recording_.fixed_pattern();
    if (reduction_ > 1 && !fixed_pattern_.empty())
        fixed_pattern_ = camera::reduced_image(fixed_pattern_, reduction_) > 0;
}

cv::Mat AlignedRecording::reduced(const cv::Mat& image) const {
    return camera::reduced_image(image, reduction_);
}

std::optional<types::StereoFrame> AlignedRecording::reduced(
    std::optional<types::StereoFrame> frame) const {
    if (!frame) return frame;
    frame->left = reduced(frame->left);
    frame->right = reduced(frame->right);
    return frame;
}

}  // namespace divemesh::pipeline
