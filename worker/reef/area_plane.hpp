#pragma once

#include <Eigen/Geometry>

#include "worker/reef/area_set.hpp"
#include "worker/reef/polygon.hpp"

namespace divemesh::reef {

// The plane of an area. It lies at the mean height of the corners along the normal; its origin is
// below or above the first corner, x points to the second corner along the plane, z is the area's
// normal. A grid of samples begins at the origin.
struct AreaPlane {
    Eigen::Isometry3d T_plane_world = Eigen::Isometry3d::Identity();
    Polygon outline;  // in the plane
};

// Returns the plane of a quadrat or a polygon. Throws Error{BadData}, which names the area, if its
// sides cross or it has no area as seen along its normal.
AreaPlane plane_of(const Area& area);

// Returns the plane from one point of a transect to the next, with heights along `normal`.
AreaPlane plane_along(const Eigen::Vector3d& from,
                      const Eigen::Vector3d& to,
                      const Eigen::Vector3d& normal);

// Returns the upward unit normal of a polygon in space from its projected areas (Newell;
// Sutherland, Sproull and Schumacker 1974); zero if it has no area.
Eigen::Vector3d upward_normal(const std::vector<Eigen::Vector3d>& corners);

}  // namespace divemesh::reef
