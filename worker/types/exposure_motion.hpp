#pragma once

#include <Eigen/Core>

#include "worker/types/rectified_rig.hpp"

namespace divemesh::types {

// The camera's motion from the exposure of a pair's left image to that of its right one, which may
// be the earlier one. To first order a point X of the rectified left camera is at
// X + rotation x X + translation by then.
struct ExposureMotion {
    RectifiedRig rig;
    Eigen::Vector3d rotation_rad = Eigen::Vector3d::Zero();
    Eigen::Vector3d translation_m = Eigen::Vector3d::Zero();
    // The disparity of points that the synchronised right image shows where a right image of the
    // left one's time would.
    double compensated_disparity_px = 0.0;

    // Returns by how many pixels along its row the point of a left pixel and a disparity has moved
    // in the right image.
    double right_shift_px(const Eigen::Vector2d& pixel, double disparity_px) const {
        const Eigen::Vector3d p = rig.point_cam(pixel.x(), pixel.y(), rig.depth_m(disparity_px));
        const Eigen::Vector3d later = p + rotation_rad.cross(p) + translation_m;
        return rig.focal_px *
               ((later.x() - rig.baseline_m) / later.z() - (p.x() - rig.baseline_m) / p.z());
    }

    // Returns the disparity of a point at the time of the left image from that at which it is
    // matched in the synchronised right image.
    double disparity_px(const Eigen::Vector2d& pixel, double matched_px) const {
        const double compensated_px = compensated_shift_px(pixel, matched_px);
        double disparity_px = matched_px;
        for (int i = 0; i < kIterations; ++i)
            disparity_px = matched_px + right_shift_px(pixel, disparity_px) - compensated_px;
        return disparity_px;
    }
    // Returns the inverse of disparity_px().
    double matched_px(const Eigen::Vector2d& pixel, double disparity_px) const {
        const double shift_px = right_shift_px(pixel, disparity_px);
        double matched_px = disparity_px;
        for (int i = 0; i < kIterations; ++i)
            matched_px = disparity_px - shift_px + compensated_shift_px(pixel, matched_px);
        return matched_px;
    }

private:
    static constexpr int kIterations = 3;

    // Returns the shift that was taken off where the point is matched.
    double compensated_shift_px(const Eigen::Vector2d& pixel, double matched_px) const {
        return right_shift_px({pixel.x() - matched_px + compensated_disparity_px, pixel.y()},
                              compensated_disparity_px);
    }
};

}  // namespace divemesh::types
