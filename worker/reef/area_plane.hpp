#pragma once

#include <Eigen/Geometry>

#include "worker/reef/area_set.hpp"
#include "worker/reef/polygon.hpp"

namespace divemesh::reef {

// Where an area lies: the plane's origin is the first corner, x runs to the second along the plane,
// z is the area's normal. A grid of samples begins at the origin.
struct AreaPlane {
    Eigen::Isometry3d T_plane_world = Eigen::Isometry3d::Identity();
    Polygon outline;  // in the plane
};

// Of a quadrat or a polygon. Throws Error{BadData} that names the area: seen along its normal it
// has no area, or its sides cross.
AreaPlane plane_of(const Area& area);

// From one point of a transect to the next, the heights along `normal`.
AreaPlane plane_along(const Eigen::Vector3d& from,
                      const Eigen::Vector3d& to,
                      const Eigen::Vector3d& normal);

// Of a polygon in space by its projected areas (Newell; Sutherland, Sproull and Schumacker 1974),
// upward. Zero where it has no area.
Eigen::Vector3d upward_normal(const std::vector<Eigen::Vector3d>& corners);

}  // namespace divemesh::reef
