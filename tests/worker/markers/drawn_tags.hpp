#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <random>
#include <vector>

#include "worker/dive/marker_plan.hpp"
#include "worker/markers/tag_layout.hpp"
#include "worker/types/rectified_rig.hpp"

namespace divemesh::markers {

inline types::RectifiedRig test_rig() {
    types::RectifiedRig rig;
    rig.width_px = 640;
    rig.height_px = 480;
    rig.focal_px = 500.0;
    rig.cx_px = 320.0;
    rig.cy_px = 240.0;
    rig.baseline_m = 0.12;
    return rig;
}

// A tag on a white board, with the true pose of its frame `marker`.
struct DrawnTag {
    dive::MarkerFamily family = dive::MarkerFamily::Tag36h11;
    int id = 0;
    double size_m = 0.12;
    Eigen::Isometry3d T_world_marker = Eigen::Isometry3d::Identity();

    Eigen::Vector3d corner_world(dive::TagCorner corner) const {
        const double half = 0.5 * size_m;
        const bool right =
            corner == dive::TagCorner::BottomRight || corner == dive::TagCorner::TopRight;
        const bool top = corner == dive::TagCorner::TopRight || corner == dive::TagCorner::TopLeft;
        return T_world_marker * Eigen::Vector3d(right ? half : -half, top ? half : -half, 0.0);
    }
};

// The degradation of an image by water and sensor.
struct Spoiling {
    double blur_px = 0.6;   // sigma
    double contrast = 1.0;  // of the scene behind the haze
    double noise = 0.0;     // sigma, grey levels
    unsigned seed = 1;
};

// Returns the pixels that can see a square of this half side, centred on the marker in its own
// plane.
inline cv::Rect pixels_of_board(double half_m,
                                const Eigen::Isometry3d& T_cam_marker,
                                const types::RectifiedRig& rig) {
    std::vector<cv::Point2f> corners;
    for (const double x : {-half_m, half_m})
        for (const double y : {-half_m, half_m}) {
            const Eigen::Vector2d at = rig.pixel(T_cam_marker * Eigen::Vector3d(x, y, 0.0));
            corners.emplace_back(static_cast<float>(at.x()), static_cast<float>(at.y()));
        }
    const cv::Rect around = cv::boundingRect(corners);
    return (around + cv::Size(2, 2) - cv::Point(1, 1)) &
           cv::Rect(0, 0, rig.width_px, rig.height_px);
}

// Returns an ideal camera's image of the tags on mottled ground, by 6 x 6 rays per pixel, degraded
// by `spoiling`.
inline cv::Mat draw(const std::vector<DrawnTag>& tags,
                    const Eigen::Isometry3d& T_world_cam,
                    const types::RectifiedRig& rig,
                    const Spoiling& spoiling = {}) {
    constexpr int kSub = 6;
    std::mt19937 random(spoiling.seed);
    cv::Mat image(rig.height_px, rig.width_px, CV_32F);
    cv::RNG rng(spoiling.seed);
    rng.fill(image, cv::RNG::NORMAL, 90.0, 40.0);
    cv::GaussianBlur(image, image, {}, 3.0);
    for (const DrawnTag& tag : tags) {
        const cv::Mat cells = tag_image(tag.family, tag.id);
        const TagLayout layout = tag_layout(tag.family);
        const double cell_m = tag.size_m / layout.size_cells;
        const double half_cells = 0.5 * layout.total_cells + 1.0;
        const Eigen::Isometry3d T_marker_cam = tag.T_world_marker.inverse() * T_world_cam;
        const Eigen::Vector3d eye = T_marker_cam.translation();
        const cv::Rect board = pixels_of_board(half_cells * cell_m, T_marker_cam.inverse(), rig);
        for (int v = board.y; v < board.br().y; ++v)
            for (int u = board.x; u < board.br().x; ++u) {
                double sum = 0.0;
                int num = 0;
                for (int i = 0; i < kSub * kSub; ++i) {
                    const double du = (i % kSub + 0.5) / kSub - 0.5;
                    const double dv = (i / kSub + 0.5) / kSub - 0.5;
                    const Eigen::Vector3d ray =
                        T_marker_cam.linear() * rig.point_cam(u + du, v + dv, 1.0);
                    const Eigen::Vector3d p = eye - eye.z() / ray.z() * ray;
                    const double x = p.x() / cell_m;
                    const double y = -p.y() / cell_m;
                    if (std::abs(x) >= half_cells || std::abs(y) >= half_cells) continue;
                    ++num;
                    const int column = static_cast<int>(std::floor(x + half_cells)) - 1;
                    const int row = static_cast<int>(std::floor(y + half_cells)) - 1;
                    const bool on_tag =
                        column >= 0 && row >= 0 && column < cells.cols && row < cells.rows;
                    sum += on_tag && cells.at<std::uint8_t>(row, column) == 0 ? 25.0 : 210.0;
                }
                if (num == 0) continue;
                float& pixel = image.at<float>(v, u);
                const double share = static_cast<double>(num) / (kSub * kSub);
                pixel = static_cast<float>((1.0 - share) * pixel + sum / (kSub * kSub));
            }
    }
    if (spoiling.blur_px > 0.0) cv::GaussianBlur(image, image, {}, spoiling.blur_px);
    image = spoiling.contrast * image + (1.0 - spoiling.contrast) * 120.0;
    std::normal_distribution<float> noise(0.0F, static_cast<float>(spoiling.noise));
    if (spoiling.noise > 0.0)
        for (int v = 0; v < image.rows; ++v)
            for (int u = 0; u < image.cols; ++u) image.at<float>(v, u) += noise(random);
    cv::Mat result;
    image.convertTo(result, CV_8U);
    return result;
}

// Returns the pose of a camera that looks down from `position`, rotated by `yaw` and tilted, rad.
inline Eigen::Isometry3d looking_down(const Eigen::Vector3d& position, double yaw, double tilt) {
    Eigen::Isometry3d T_world_cam = Eigen::Isometry3d::Identity();
    T_world_cam.translation() = position;
    T_world_cam.linear() =
        (Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()) *
         Eigen::AngleAxisd(static_cast<double>(EIGEN_PI) + tilt, Eigen::Vector3d::UnitX()))
            .toRotationMatrix();
    return T_world_cam;
}

// Returns the pose of a camera at this height that sees the origin at the image centre.
inline Eigen::Isometry3d looking_at_origin(double height_m, double yaw, double tilt) {
    const Eigen::Vector3d aside(0.0, -height_m * std::tan(tilt), height_m);
    return looking_down(Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()) * aside, yaw, tilt);
}

}  // namespace divemesh::markers
