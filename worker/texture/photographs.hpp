#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <vector>

#include "worker/base/parallel.hpp"
#include "worker/keyframes/keyframe_images.hpp"
#include "worker/types/keyframe.hpp"
#include "worker/types/rectified_rig.hpp"

namespace divemesh::texture {

// The images of the keyframes, at the rig's size, and the cameras that took them. What it refers to
// must outlive it.
class Photographs {
public:
    Photographs(const types::RectifiedRig& rig,
                const std::vector<types::Keyframe>& keyframes,
                const keyframes::ReadImage& read_image);

    std::size_t num_keyframes() const { return keyframes_.size(); }
    cv::Size size_px() const { return {rig_.width_px, rig_.height_px}; }

    // Returns where a keyframe's image shows a point, moved to the image's edge from beyond it
    // (pixel centres at integers); nullopt if the point is not in front of the camera.
    std::optional<Eigen::Vector2d> pixel(std::int32_t keyframe,
                                         const Eigen::Vector3f& p_world) const;

    // Calls visit(keyframe, image) for each of `keyframes` on `num_threads` threads, which hold one
    // image each. An image that cannot be read, or is not CV_8UC3 of the rig's size, is empty.
    using Visit = std::function<void(std::int32_t keyframe, const cv::Mat& image)>;
    void for_each_image(const std::vector<std::int32_t>& keyframes,
                        int num_threads,
                        const base::ProgressShare& progress,
                        const Visit& visit) const;

private:
    cv::Mat read_or_empty(std::int32_t keyframe) const;

    const types::RectifiedRig& rig_;
    const std::vector<types::Keyframe>& keyframes_;
    const keyframes::ReadImage& read_image_;
    std::vector<Eigen::Isometry3d> T_cam_world_;
};

}  // namespace divemesh::texture
