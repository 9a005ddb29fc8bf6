#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "worker/mesh/triangle_runs.hpp"
#include "worker/types/rectified_rig.hpp"

namespace divemesh::mesh {

// A rectified left camera with the pixels of an image that shows the same at any resolution; pixel
// centres are at halves, as for_each_pixel() has them.
struct ImageCamera {
    Eigen::Isometry3f T_cam_world;
    int columns = 0;
    int rows = 0;
    float focal_px = 0.0F;
    float cx_px = 0.0F;
    float cy_px = 0.0F;

    ImageCamera(const types::RectifiedRig& rig,
                const Eigen::Isometry3d& T_world_cam,
                int num_columns,
                int num_rows)
        : T_cam_world(T_world_cam.inverse().cast<float>()), columns(num_columns), rows(num_rows) {
        const double scale = static_cast<double>(columns) / std::max(1, rig.width_px);
        focal_px = static_cast<float>(scale * rig.focal_px);
        cx_px = static_cast<float>(scale * (rig.cx_px + 0.5));
        cy_px = static_cast<float>(scale * (rig.cy_px + 0.5));
    }

    // Returns the pixel with the inverse depth as z, which is linear over a triangle; z is 0 for a
    // point that is not in front of the camera.
    Eigen::Vector3f project(const Eigen::Vector3f& p_world) const {
        constexpr auto kMinDepth_m = static_cast<float>(types::RectifiedRig::kMinDepth_m);
        const Eigen::Vector3f p = T_cam_world * p_world;
        if (p.z() < kMinDepth_m) return Eigen::Vector3f::Zero();
        const float inverse = 1.0F / p.z();
        const float scale = focal_px * inverse;
        return {scale * p.x() + cx_px, scale * p.y() + cy_px, inverse};
    }

    // Returns false only if the image shows nothing of the triangles.
    bool may_see(const TriangleRun& run) const {
        const Eigen::Vector3f p = T_cam_world * run.center_world;
        const auto is_inside = [&](float along, float principal_px, int size_px) {
            const float other_px = static_cast<float>(size_px) - principal_px;
            return (focal_px * along + principal_px * p.z()) >=
                       -run.radius_m * std::hypot(focal_px, principal_px) &&
                   (other_px * p.z() - focal_px * along) >=
                       -run.radius_m * std::hypot(focal_px, other_px);
        };
        return p.z() > -run.radius_m && is_inside(p.x(), cx_px, columns) &&
               is_inside(p.y(), cy_px, rows);
    }
};

}  // namespace divemesh::mesh
