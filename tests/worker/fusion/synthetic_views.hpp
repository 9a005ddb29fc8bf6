#pragma once

#include <Eigen/Geometry>
#include <functional>
#include <opencv2/core.hpp>
#include <random>
#include <vector>

#include "tests/synthetic/ideal_rig.hpp"
#include "worker/types/keyframe.hpp"

namespace divemesh::fusion {

using SceneDistance = std::function<double(const Eigen::Vector3d& p_world)>;

inline types::RectifiedRig small_rig() { return synthetic::ideal_rig(240, 180, 180.0); }

// Returns the pose of a camera at `eye` that looks at `target`. The image's up direction is world
// y, or world x if the camera looks along y.
inline Eigen::Isometry3d look_at(const Eigen::Vector3d& eye, const Eigen::Vector3d& target) {
    const Eigen::Vector3d forward = (target - eye).normalized();
    const Eigen::Vector3d right = forward.cross(Eigen::Vector3d::UnitY()).normalized();
    Eigen::Isometry3d T_world_cam = Eigen::Isometry3d::Identity();
    T_world_cam.linear().col(0) = right;
    T_world_cam.linear().col(1) = forward.cross(right);
    T_world_cam.linear().col(2) = forward;
    T_world_cam.translation() = eye;
    return T_world_cam;
}

struct ViewNoise {
    double sigma_px = 0.0;  // of the disparity
    double bias_px = 0.0;
    double stated_sigma_px = 0.1;
};

struct SyntheticView {
    types::Keyframe keyframe;
    types::KeyframeImages images;
};

// Returns the colour of a place: red, green and blue increase with world x, y and z.
inline Eigen::Vector3d paint_at(const Eigen::Vector3d& p_world) {
    return 100.0 * p_world + Eigen::Vector3d(120.0, 100.0, 60.0);
}

// Renders a stereo camera's view of a scene, given as a signed distance, by sphere tracing.
inline SyntheticView render_view(const SceneDistance& scene,
                                 const types::RectifiedRig& rig,
                                 const Eigen::Isometry3d& T_world_cam,
                                 const ViewNoise& noise = {},
                                 unsigned seed = 1) {
    SyntheticView view;
    view.keyframe.T_world_cam = T_world_cam;
    const cv::Size size(rig.width_px, rig.height_px);
    view.images.left_color = cv::Mat(size, CV_8UC3, cv::Scalar(0, 0, 0));
    view.images.depth.disparity_px = cv::Mat(size, CV_32F, cv::Scalar(0.0));
    view.images.depth.sigma_disparity_px = cv::Mat(size, CV_32F, cv::Scalar(noise.stated_sigma_px));
    std::mt19937 random(seed);
    std::normal_distribution<double> error(noise.bias_px, std::max(1e-12, noise.sigma_px));
    for (int v = 0; v < size.height; ++v)
        for (int u = 0; u < size.width; ++u) {
            const Eigen::Vector3d ray = rig.point_cam(u, v, 1.0);
            double depth = 0.2;
            for (int step = 0; step < 200 && depth < 6.0; ++step) {
                const double distance = scene(T_world_cam * (depth * ray));
                if (distance < 1e-6) break;
                depth += distance / ray.norm();
            }
            if (depth >= 6.0) continue;
            const Eigen::Vector3d paint = paint_at(T_world_cam * (depth * ray));
            view.images.left_color.at<cv::Vec3b>(v, u) =
                cv::Vec3b(cv::saturate_cast<std::uint8_t>(paint.z()),
                          cv::saturate_cast<std::uint8_t>(paint.y()),
                          cv::saturate_cast<std::uint8_t>(paint.x()));
            view.images.depth.disparity_px.at<float>(v, u) =
                static_cast<float>(rig.disparity_px(depth) + error(random));
        }
    return view;
}

// Returns the signed distance of a sphere half sunk into a floor.
inline double bump_on_floor(const Eigen::Vector3d& p) {
    return std::min(p.z(), (p - Eigen::Vector3d(0.05, 0.0, -0.05)).norm() - 0.3);
}

inline std::vector<Eigen::Isometry3d> views_from_above(int num, double height_m) {
    std::vector<Eigen::Isometry3d> poses;
    for (int i = 0; i < num; ++i) {
        const double along = -0.3 + 0.6 * i / std::max(1, num - 1);
        poses.push_back(
            look_at({along, -0.2 + 0.1 * (i % 4), height_m}, {0.5 * along, 0.05 * (i % 3), 0.0}));
    }
    return poses;
}

}  // namespace divemesh::fusion
