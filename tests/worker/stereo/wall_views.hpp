#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <functional>
#include <opencv2/core.hpp>
#include <random>
#include <vector>

#include "tests/worker/stereo/warped_pair.hpp"
#include "worker/stereo/neighbour_view.hpp"
#include "worker/types/rectified_rig.hpp"

namespace divemesh::stereo {

using Shade = std::function<double(double x_m, double y_m)>;

inline constexpr double kDepth_m = 2.0;
inline constexpr double kPixels_per_m = 150.0;  // of the texture: about one at each pixel

inline double textured(double x_m, double y_m) {
    return texture(kPixels_per_m * x_m, kPixels_per_m * y_m);
}

inline types::RectifiedRig rig() {
    types::RectifiedRig rig;
    rig.width_px = 320;
    rig.height_px = 240;
    rig.focal_px = 300.0;
    rig.cx_px = 161.0;
    rig.cy_px = 118.0;
    rig.baseline_m = 0.1;
    return rig;
}

// A slanted wall, z = 2 + 0.3 x + 0.1 y, seen by cameras beside and above each other.
inline Eigen::Vector3d on_wall(const Eigen::Isometry3d& T_world_cam, double u_px, double v_px) {
    const Eigen::Vector3d ray = T_world_cam.linear() * rig().point_cam(u_px, v_px, 1.0);
    const Eigen::Vector3d from = T_world_cam.translation();
    const Eigen::Vector3d normal(-0.3, -0.1, 1.0);
    return from + ray * ((kDepth_m - normal.dot(from)) / normal.dot(ray));
}

inline cv::Mat photograph(const Eigen::Isometry3d& T_world_cam, const Shade& shade, unsigned seed) {
    std::mt19937 random(seed);
    std::normal_distribution<double> noise(0.0, 2.0);
    cv::Mat image(240, 320, CV_8U);
    for (int v = 0; v < image.rows; ++v)
        for (int u = 0; u < image.cols; ++u) {
            const Eigen::Vector3d p_world = on_wall(T_world_cam, u, v);
            image.at<std::uint8_t>(v, u) = cv::saturate_cast<std::uint8_t>(
                128.0 + shade(p_world.x(), p_world.y()) + noise(random));
        }
    return image;
}

inline cv::Mat true_disparity_px() {
    cv::Mat disparity_px(240, 320, CV_32F);
    for (int v = 0; v < 240; ++v)
        for (int u = 0; u < 320; ++u)
            disparity_px.at<float>(v, u) = static_cast<float>(
                rig().disparity_px(on_wall(Eigen::Isometry3d::Identity(), u, v).z()));
    return disparity_px;
}

inline Eigen::Isometry3d camera(double x_m, double y_m, double yaw_deg) {
    Eigen::Isometry3d T_world_cam = Eigen::Isometry3d::Identity();
    T_world_cam.translation() = Eigen::Vector3d(x_m, y_m, 0.02);
    T_world_cam.linear() =
        Eigen::AngleAxisd(yaw_deg / 180.0 * M_PI, Eigen::Vector3d::UnitY()).toRotationMatrix();
    return T_world_cam;
}

// A depth map's image of the wall, and four frames around it.
struct WallViews {
    explicit WallViews(const Shade& shade) {
        left = photograph(Eigen::Isometry3d::Identity(), shade, 1);
        for (const Eigen::Isometry3d& T_world_cam : cameras())
            neighbours.push_back(
                {photograph(T_world_cam, shade, static_cast<unsigned>(neighbours.size()) + 2),
                 T_world_cam.inverse()});
    }
    static std::vector<Eigen::Isometry3d> cameras() {
        return {camera(-0.25, 0.0, -2.0),
                camera(-0.12, 0.05, 1.0),
                camera(0.13, -0.04, 0.5),
                camera(0.26, 0.02, 3.0)};
    }

    cv::Mat left;
    std::vector<NeighbourView> neighbours;
};

}  // namespace divemesh::stereo
