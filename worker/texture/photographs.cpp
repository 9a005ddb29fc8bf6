#include "worker/texture/photographs.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>

#include "schemas/error.hpp"

namespace divemesh::texture {

Photographs::Photographs(const types::RectifiedRig& rig,
                         const std::vector<types::Keyframe>& keyframes,
                         const keyframes::ReadImage& read_image)
    : rig_(rig), keyframes_(keyframes), read_image_(read_image) {
    for (const types::Keyframe& keyframe : keyframes)
        T_cam_world_.push_back(keyframe.T_world_cam.inverse());
}

std::optional<Eigen::Vector2d> Photographs::pixel(std::int32_t keyframe,
                                                  const Eigen::Vector3f& p_world) const {
    const Eigen::Vector3d p_cam = T_cam_world_[keyframe] * p_world.cast<double>();
    if (!p_cam.allFinite() || p_cam.z() < types::RectifiedRig::kMinDepth_m) return std::nullopt;
    const Eigen::Vector2d last_px(rig_.width_px - 1, rig_.height_px - 1);
    return rig_.pixel(p_cam).cwiseMax(0.0).cwiseMin(last_px);
}

void Photographs::for_each_image(const std::vector<std::int32_t>& keyframes,
                                 int num_threads,
                                 const base::ProgressShare& progress,
                                 const Visit& visit) const {
    constexpr std::size_t kSlice = 8;  // images between two checks for cancellation
    for (std::size_t begin = 0; begin < keyframes.size(); begin += kSlice) {
        progress.at(static_cast<double>(begin) / static_cast<double>(keyframes.size()));
        base::for_each_index(
            num_threads, std::min(kSlice, keyframes.size() - begin), [&](std::size_t i) {
                visit(keyframes[begin + i], read_or_empty(keyframes[begin + i]));
            });
    }
    progress.at(1.0);
}

cv::Mat Photographs::read_or_empty(std::int32_t keyframe) const {
    try {
        const cv::Mat image = read_image_(keyframes_[keyframe].frame_index);
        return image.type() == CV_8UC3 && image.size() == size_px() ? image : cv::Mat();
    } catch (const Error& error) {
        if (error.code() == ErrorCode::Cancelled || error.code() == ErrorCode::OutOfMemory) throw;
    } catch (const cv::Exception&) {  // of a decoder
    }
    return {};
}

}  // namespace divemesh::texture
