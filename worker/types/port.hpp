#pragma once

#include <Eigen/Core>
#include <cstdint>

namespace divemesh::types {

// The glass between the air before a lens and the water. Directions are in axes of the camera,
// refractive indices relative to air.
struct Port {
    enum class Shape : std::uint8_t { Flat, Dome };

    Shape shape = Shape::Flat;
    // A flat port has a unit normal towards the water, and a distance along it from the lens, that
    // is from its centre of projection, to the inner face.
    Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();
    double distance_m = 0.0;
    // A dome has a centre, as seen from the lens, and the radius of its inner face.
    Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();
    double radius_m = 0.0;
    double thickness_m = 0.0;
    double glass_index = 1.49;
    double water_index = 0.0;  // 0: not known yet
    // Where the lens is in the camera's frame.
    Eigen::Vector3d p_lens_cam = Eigen::Vector3d::Zero();
    // The depth, m in front of the camera, at which the ray of a pixel is exact if it is drawn from
    // the camera's origin.
    double reference_depth_m = 1.5;
};

}  // namespace divemesh::types
