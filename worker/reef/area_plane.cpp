#include "worker/reef/area_plane.hpp"

#include "schemas/error.hpp"

namespace divemesh::reef {
namespace {

constexpr double kMinArea_m2 = 1e-8;  // a square of 0.1 mm

Eigen::Isometry3d T_plane_world(const Eigen::Vector3d& origin,
                                const Eigen::Vector3d& ahead,
                                const Eigen::Vector3d& normal) {
    Eigen::Vector3d x = ahead - ahead.dot(normal) * normal;
    x = x.norm() > 1e-9 ? x.normalized() : normal.unitOrthogonal();
    Eigen::Isometry3d T_world_plane = Eigen::Isometry3d::Identity();
    T_world_plane.linear().col(0) = x;
    T_world_plane.linear().col(1) = normal.cross(x);
    T_world_plane.linear().col(2) = normal;
    T_world_plane.translation() = origin;
    return T_world_plane.inverse();
}

}  // namespace

Eigen::Vector3d upward_normal(const std::vector<Eigen::Vector3d>& corners) {
    Eigen::Vector3d twice = Eigen::Vector3d::Zero();
    for (std::size_t i = 0; i < corners.size(); ++i)
        twice += (corners[i] - corners[0]).cross(corners[(i + 1) % corners.size()] - corners[0]);
    if (!(twice.norm() > 2.0 * kMinArea_m2)) return Eigen::Vector3d::Zero();
    const Eigen::Vector3d normal = twice.normalized();
    return normal.z() < 0.0 ? Eigen::Vector3d(-normal) : normal;
}

AreaPlane plane_of(const Area& area) {
    const Eigen::Vector3d normal = area.normal.value_or(upward_normal(area.points));
    if (normal.isZero())
        throw Error(ErrorCode::BadData,
                    "area '" + area.name +
                        "' has no area, because its corners are on a line or its sides cross: "
                        "check the corners");
    AreaPlane plane;
    plane.T_plane_world = T_plane_world(area.points[0], area.points[1] - area.points[0], normal);
    double sum_of_heights_m = 0.0;
    for (const Eigen::Vector3d& point : area.points) {
        const Eigen::Vector3d p_plane = plane.T_plane_world * point;
        plane.outline.emplace_back(p_plane.head<2>());
        sum_of_heights_m += p_plane.z();
    }
    plane.T_plane_world.translation().z() -=
        sum_of_heights_m / static_cast<double>(area.points.size());
    if (is_self_crossing(plane.outline))
        throw Error(ErrorCode::BadData,
                    "area '" + area.name +
                        "': its sides cross or touch: give the corners in order, each once");
    if (!(area_m2(plane.outline) > kMinArea_m2))
        throw Error(
            ErrorCode::BadData,
            "area '" + area.name +
                "' has no area when seen along its normal: check the normal and the corners");
    return plane;
}

AreaPlane plane_along(const Eigen::Vector3d& from,
                      const Eigen::Vector3d& to,
                      const Eigen::Vector3d& normal) {
    AreaPlane plane;
    plane.T_plane_world = T_plane_world(from, to - from, normal);
    plane.outline = {(plane.T_plane_world * from).head<2>(), (plane.T_plane_world * to).head<2>()};
    return plane;
}

}  // namespace divemesh::reef
