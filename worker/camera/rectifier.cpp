#include "worker/camera/rectifier.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "schemas/error.hpp"
#include "worker/camera/projection.hpp"
#include "worker/camera/range_correction.hpp"
#include "worker/camera/rectified_lens.hpp"

namespace divemesh::camera {
namespace {

constexpr int kMinScene_px = 32;  // width and height of the part that shows the scene

// The rectangle of a normalised image plane that the image covers completely.
struct Extent {
    double left = -1e9;
    double right = 1e9;
    double top = -1e9;
    double bottom = 1e9;
};

// Narrows the extent to what a part of the recorded image covers.
void narrow(Extent& extent,
            const types::Camera& camera,
            const cv::Rect& part,
            const Eigen::Matrix3d& R_rectified_camera) {
    const auto ray = [&](double u, double v) {
        const Eigen::Vector3d r = R_rectified_camera * unproject(camera, {u, v});
        return Eigen::Vector2d(r.head<2>() / std::max(r.z(), 1e-3));
    };
    constexpr int kSteps = 32;
    const double left = part.x;
    const double top = part.y;
    const double right = part.x + part.width - 1.0;
    const double bottom = part.y + part.height - 1.0;
    for (int i = 0; i <= kSteps; ++i) {
        const double share = static_cast<double>(i) / kSteps;
        const double u = left + share * (right - left);
        const double v = top + share * (bottom - top);
        extent.left = std::max(extent.left, ray(left, v).x());
        extent.right = std::min(extent.right, ray(right, v).x());
        extent.top = std::max(extent.top, ray(u, top).y());
        extent.bottom = std::min(extent.bottom, ray(u, bottom).y());
    }
}

Extent extent_of(const types::Rig& rig,
                 const cv::Rect& part,
                 const std::array<RectifiedLens, 2>& lenses) {
    Extent extent;
    narrow(extent, rig.cam0, part, lenses[0].R_camera_rectified.transpose());
    narrow(extent, rig.cam1, part, lenses[1].R_camera_rectified.transpose());
    return extent;
}

// Returns the focal length, in px, with which an image covers the extent and no more.
double covering_px(const Extent& extent, double width, double height) {
    return std::max(width / (extent.right - extent.left), height / (extent.bottom - extent.top));
}

// Returns the part of recorded images that shows the scene.
cv::Rect scene_part(const types::Camera& camera, const cv::Mat& fixed_pattern) {
    const cv::Rect all(0, 0, camera.width_px, camera.height_px);
    if (fixed_pattern.empty()) return all;
    const cv::Rect part = cv::boundingRect(fixed_pattern == 0);
    return part.width > kMinScene_px && part.height > kMinScene_px ? part : all;
}

}  // namespace

types::RectifiedRig rectified_rig(const types::Rig& rig, const cv::Mat& fixed_pattern) {
    const Eigen::Isometry3d T_cam0_cam1 = rig.T_cam1_cam0().inverse();
    if (T_cam0_cam1.translation().x() <= 0.0)
        throw Error(ErrorCode::BadData,
                    "the right camera is not to the right of the left one: check T_BS of cam0 and "
                    "cam1, or swap the two folders");
    const auto lenses = rectified_lenses(rig);
    const auto& [left, right] = lenses;
    const Extent extent = extent_of(rig, scene_part(rig.cam0, fixed_pattern), lenses);
    const Extent whole = extent_of(rig, scene_part(rig.cam0, {}), lenses);
    const double width = rig.cam0.width_px - 1.0;
    const double height = rig.cam0.height_px - 1.0;
    types::RectifiedRig rectified;
    // The widest field of view without empty borders. Where black surrounds the scene, the scene is
    // in the middle, and not enlarged; empty borders belong to the fixed pattern then. A fisheye
    // image is cut to its middle: at half of its focal length, 72 degrees to both sides at an image
    // width of 3.1 focal lengths.
    const double native = axial_magnification(rig.cam0) * 0.25 *
                          (rig.cam0.fx_px + rig.cam0.fy_px + rig.cam1.fx_px + rig.cam1.fy_px);
    const double covering = std::min(covering_px(extent, width, height),
                                     std::max(native, covering_px(whole, width, height)));
    rectified.focal_px = std::max(covering, 0.5 * native);
    if (!std::isfinite(rectified.focal_px) || extent.right <= extent.left ||
        extent.bottom <= extent.top || rectified.focal_px > 4.0 * native)
        throw Error(ErrorCode::BadData,
                    "the fields of view of the two cameras hardly overlap: check T_BS and "
                    "intrinsics of cam0 and cam1");
    rectified.width_px = rig.cam0.width_px;
    rectified.height_px = rig.cam0.height_px;
    const bool is_middle = rectified.focal_px > covering;
    const auto middle = [&](double begin, double end, double size) {
        if (!is_middle) return 0.5 * (begin + end);
        const double half = 0.5 * size / rectified.focal_px;
        // The point in view that is nearest to the axis.
        return std::clamp(0.0, begin + half, end - half);
    };
    rectified.cx_px = 0.5 * width - rectified.focal_px * middle(extent.left, extent.right, width);
    rectified.cy_px = 0.5 * height - rectified.focal_px * middle(extent.top, extent.bottom, height);
    rectified.baseline_m = rig.baseline_m();
    rectified.T_imu_cam = rig.T_imu_cam0;
    rectified.T_imu_cam.linear() = rig.T_imu_cam0.linear() * left.R_camera_rectified;
    return rectified;
}

ImageRectifier left_rectifier(const types::Recording& recording, int num_threads) {
    return {rectified_lenses(recording.rig())[0],
            rectified_rig(recording.rig(), recording.fixed_pattern()),
            num_threads};
}

Rectifier::Rectifier(const types::Rig& rig, const cv::Mat& fixed_pattern, int num_threads)
    : rig_(rectified_rig(rig, fixed_pattern)),
      left_(rectified_lenses(rig)[0], rig_, num_threads),
      right_(rectified_lenses(rig)[1], rig_, num_threads),
      ranges_(range_table(rig, rig_, num_threads)) {
    if (!fixed_pattern.empty()) fixed_pattern_ = left_.rectify_mask(fixed_pattern);
    for (const types::CameraTurn& turn : rig.right_turns)
        turned_.push_back(
            {turn.from_ns, {turned_lens(rectified_lenses(rig)[1], turn), rig_, num_threads}});
}

const ImageRectifier& Rectifier::right_at(std::int64_t timestamp_ns) const {
    const ImageRectifier* right = &right_;
    for (const Turned& turned : turned_)
        if (timestamp_ns >= turned.from_ns) right = &turned.right;
    return *right;
}

types::RectifiedFrame Rectifier::rectify(const types::StereoFrame& frame) const {
    types::RectifiedFrame result;
    result.index = frame.index;
    result.timestamp_ns = frame.timestamp_ns;
    result.left = left_.rectify(frame.left);
    result.right = right_at(frame.timestamp_ns).rectify(frame.right);
    result.fixed_pattern = fixed_pattern_;
    result.ranges = ranges_;
    result.right_delay_s = frame.right_delay_s;
    return result;
}

}  // namespace divemesh::camera
