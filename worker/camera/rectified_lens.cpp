#include "worker/camera/rectified_lens.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <opencv2/imgproc.hpp>

#include "worker/base/rotation_vector.hpp"
#include "worker/camera/projection.hpp"

namespace divemesh::camera {
namespace {

// Returns the axes of the rectified camera in the frame of cam0, axis i in column i.
Eigen::Matrix3d rectified_axes(const Eigen::Isometry3d& T_cam0_cam1) {
    const Eigen::AngleAxisd rotation(T_cam0_cam1.linear());
    const Eigen::Matrix3d middle =
        Eigen::AngleAxisd(0.5 * rotation.angle(), rotation.axis()).toRotationMatrix();
    Eigen::Matrix3d axes;
    axes.col(0) = T_cam0_cam1.translation().normalized();
    axes.col(1) = middle.col(2).cross(axes.col(0)).normalized();
    axes.col(2) = axes.col(0).cross(axes.col(1));
    return axes;
}

// Returns the pixel that shows what lies on a ray from the camera's origin; behind a port, what
// lies there at the reference depth.
Eigen::Vector2d pixel_of(const types::Camera& camera, const Eigen::Vector3d& ray_cam) {
    const Eigen::Vector2d outside(-1.0, -1.0);
    if (!camera.port) return project(camera, ray_cam).value_or(outside);
    const double depth_m = camera.port->reference_depth_m;
    return project(camera, ray_cam * (depth_m / ray_cam.z())).value_or(outside);
}

}  // namespace

Eigen::Vector2d RectifiedLens::recorded_px(const types::RectifiedRig& rig,
                                           const Eigen::Vector2d& rectified_px) const {
    return pixel_of(camera,
                    R_camera_rectified * rig.point_cam(rectified_px.x(), rectified_px.y(), 1.0));
}

Eigen::Vector2d RectifiedLens::rectified_px(const types::RectifiedRig& rig,
                                            const Eigen::Vector2d& recorded_px) const {
    Eigen::Vector3d ray = R_camera_rectified.transpose() * unproject(camera, recorded_px);
    ray.z() = std::max(ray.z(), 1e-3);
    return rig.pixel(ray);
}

std::array<RectifiedLens, 2> rectified_lenses(const types::Rig& rig) {
    const Eigen::Isometry3d T_cam0_cam1 = rig.T_cam1_cam0().inverse();
    const Eigen::Matrix3d R_cam0_rectified = rectified_axes(T_cam0_cam1);
    return {{{rig.cam0, R_cam0_rectified},
             {rig.cam1, T_cam0_cam1.linear().transpose() * R_cam0_rectified}}};
}

RectifiedLens turned_lens(const RectifiedLens& right, const types::CameraTurn& turn) {
    RectifiedLens turned = right;
    turned.R_camera_rectified =
        base::rotation_from_vector(turn.rotation).toRotationMatrix().transpose() *
        right.R_camera_rectified;
    turned.camera.fx_px *= 1.0 + turn.focal;
    turned.camera.fy_px *= 1.0 + turn.focal;
    return turned;
}

types::Camera reduced_camera(const types::Camera& camera, int reduction) {
    types::Camera result = camera;
    result.width_px /= reduction;
    result.height_px /= reduction;
    result.fx_px /= reduction;
    result.fy_px /= reduction;
    // Pixel centres are whole numbers in both sizes.
    result.cx_px = (camera.cx_px + 0.5) / reduction - 0.5;
    result.cy_px = (camera.cy_px + 0.5) / reduction - 0.5;
    return result;
}

cv::Mat reduced_image(const cv::Mat& image, int reduction) {
    if (reduction == 1 || image.empty()) return image;
    const cv::Size size(image.cols / reduction, image.rows / reduction);
    const cv::Rect squares(0, 0, size.width * reduction, size.height * reduction);
    cv::Mat result;
    cv::resize(image(squares), result, size, 0.0, 0.0, cv::INTER_AREA);
    return result;
}

types::Camera changed_camera(const types::Camera& camera, const types::LensChange& change) {
    types::Camera result = camera;
    result.fx_px *= 1.0 + change.values[0];
    result.fy_px *= 1.0 + change.values[0];
    result.cx_px += change.values[1];
    result.cy_px += change.values[2];
    result.distortion_coefficients[0] += change.values[3];
    result.distortion_coefficients[1] += change.values[4];
    return result;
}

Eigen::Matrix<double, 2, types::LensChange::kSize> shift_of_change(
    const types::RectifiedRig& rig,
    const RectifiedLens& lens,
    const Eigen::Vector2d& rectified_px) {
    constexpr double kStep_px = 0.5;
    Eigen::Matrix2d recorded_by_rectified;
    for (int axis = 0; axis < 2; ++axis) {
        const Eigen::Vector2d step = kStep_px * Eigen::Vector2d::Unit(axis);
        recorded_by_rectified.col(axis) = (lens.recorded_px(rig, rectified_px + step) -
                                           lens.recorded_px(rig, rectified_px - step)) /
                                          (2.0 * kStep_px);
    }
    const Eigen::Vector3d ray =
        lens.R_camera_rectified * rig.point_cam(rectified_px.x(), rectified_px.y(), 1.0);
    Eigen::Matrix<double, 2, types::LensChange::kSize> recorded_by_change;
    for (int i = 0; i < types::LensChange::kSize; ++i) {
        types::LensChange above;
        types::LensChange below;
        const double step = i == 1 || i == 2 ? 0.1 : 1e-4;
        above.values[i] = step;
        below.values[i] = -step;
        recorded_by_change.col(i) = (pixel_of(changed_camera(lens.camera, above), ray) -
                                     pixel_of(changed_camera(lens.camera, below), ray)) /
                                    (2.0 * step);
    }
    return recorded_by_rectified.inverse() * recorded_by_change;
}

}  // namespace divemesh::camera
