#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <cstdint>
#include <opencv2/core.hpp>

#include "tests/synthetic/stereo_world.hpp"
#include "worker/features/described_keypoints.hpp"
#include "worker/types/keyframe.hpp"

namespace divemesh::synthetic {

// Returns a rig of 320x240 px that looks at the floor.
inline types::RectifiedRig small_rig() {
    types::RectifiedRig small = ideal_rig(320, 240, 250.0);
    small.T_imu_cam = rig().T_imu_cam;
    return small;
}

// A flat floor with speckles of three sizes, whose brightness is known exactly everywhere. With a
// period along x it repeats after that distance.
class SeaFloor {
public:
    static constexpr double kDepth_m = 2.0;  // the plane z = 2 m in the world

    explicit SeaFloor(double period_m = 1e6) : period_m_(period_m) {}

    double brightness(double x_m, double y_m) const {
        const double x = x_m - period_m_ * std::floor(x_m / period_m_);
        double sum = 128.0;
        double cell_m = 0.04;
        for (std::uint64_t octave = 0; octave < 3; ++octave, cell_m *= 2.5)
            sum += 50.0 * smooth(x / cell_m, y_m / cell_m, octave);
        return sum;
    }

    // Renders the image of a camera, with the depth of every pixel.
    types::KeyframeImages look(const Eigen::Isometry3d& T_world_cam) const {
        const types::RectifiedRig rig = small_rig();
        cv::Mat gray(rig.height_px, rig.width_px, CV_8U);
        types::KeyframeImages images;
        images.depth.disparity_px.create(gray.size(), CV_32F);
        images.depth.sigma_disparity_px.create(gray.size(), CV_32F);
        images.depth.sigma_disparity_px.setTo(0.1F);
        for (int v = 0; v < gray.rows; ++v) {
            for (int u = 0; u < gray.cols; ++u) {
                const Eigen::Vector3d p_cam = seen_at(T_world_cam, u, v);
                const Eigen::Vector3d p_world = T_world_cam * p_cam;
                gray.at<std::uint8_t>(v, u) =
                    cv::saturate_cast<std::uint8_t>(brightness(p_world.x(), p_world.y()));
                images.depth.disparity_px.at<float>(v, u) =
                    static_cast<float>(rig.disparity_px(p_cam.z()));
            }
        }
        cv::merge(std::vector<cv::Mat>{gray, gray, gray}, images.left_color);
        return images;
    }

    // Returns the described keypoints of an image, with their disparities.
    static features::DescribedKeypoints view(const Eigen::Isometry3d& T_world_cam,
                                             const types::KeyframeImages& images) {
        cv::Mat gray;
        cv::extractChannel(images.left_color, gray, 0);
        features::DescribedKeypoints view = features::describe_keypoints(gray);
        for (features::DescribedKeypoint& point : view)
            point.disparity_px = static_cast<float>(
                small_rig().disparity_px(seen_at(T_world_cam, point.u_px, point.v_px).z()));
        return view;
    }

    // Returns the point of the floor at a pixel, in the camera frame.
    static Eigen::Vector3d seen_at(const Eigen::Isometry3d& T_world_cam, double u_px, double v_px) {
        const Eigen::Vector3d ray_cam = small_rig().point_cam(u_px, v_px, 1.0);
        const Eigen::Vector3d ray_world = T_world_cam.linear() * ray_cam;
        return ray_cam * ((kDepth_m - T_world_cam.translation().z()) / ray_world.z());
    }

private:
    // Returns -0.5 to 0.5 at the corners of the lattice, with a smooth step in between.
    static double smooth(double x, double y, std::uint64_t octave) {
        const double column = std::floor(x);
        const double row = std::floor(y);
        const double right = step(x - column);
        const double below = step(y - row);
        const auto at = [&](double dx, double dy) { return hash(column + dx, row + dy, octave); };
        return (1 - below) * ((1 - right) * at(0, 0) + right * at(1, 0)) +
               below * ((1 - right) * at(0, 1) + right * at(1, 1));
    }
    static double step(double t) { return t * t * (3.0 - 2.0 * t); }
    static double hash(double column, double row, std::uint64_t octave) {
        std::uint64_t h =
            static_cast<std::uint64_t>(static_cast<std::int64_t>(column)) * 0x9E3779B97F4A7C15U ^
            static_cast<std::uint64_t>(static_cast<std::int64_t>(row)) * 0xC2B2AE3D27D4EB4FU ^
            (octave + 1) * 0x165667B19E3779F9U;
        h = (h ^ (h >> 31)) * 0xBF58476D1CE4E5B9U;
        h = (h ^ (h >> 29)) * 0x94D049BB133111EBU;
        return static_cast<double>((h ^ (h >> 32)) >> 11) * 0x1.0p-53 - 0.5;
    }

    double period_m_;
};

}  // namespace divemesh::synthetic
