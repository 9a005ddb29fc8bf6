#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <vector>

#include "worker/types/geographic_position.hpp"

namespace divemesh::io {

// The world's horizontal plane in Universal Transverse Mercator: (easting, northing) [m] = A * (x,
// y, 1). A contains the convergence of the meridian and the scale of the projection at the origin;
// within 500 m the change of both has an effect of less than a millimetre.
struct UtmFrame {
    int epsg = 0;  // 326zz north, 327zz south of the equator
    Eigen::Matrix<double, 2, 3> A = Eigen::Matrix<double, 2, 3>::Zero();
};

// Returns the UTM frame of a position. If the azimuth is unknown, the world's y axis is assumed to
// point north. Throws Error{InvalidArgument} for an invalid position.
UtmFrame utm_frame(const types::GeographicPosition& position);

// Returns the same in a given zone, which may be that of a neighbour.
UtmFrame utm_frame(const types::GeographicPosition& position, int utm_epsg);

// Returns where a place (easting, northing) [m] of a UTM zone is. Throws Error{BadData} if it has
// no latitude and longitude.
types::GeographicPosition geographic_position(const Eigen::Vector2d& utm_m, int utm_epsg);

// Returns the pose of the world in earth-centred, earth-fixed coordinates (EPSG:4978), with its
// origin at height 0 of the ellipsoid. If the azimuth is unknown, the world's y axis is assumed to
// point north. Throws Error{InvalidArgument} for an invalid position.
Eigen::Isometry3d earth_from_world(const types::GeographicPosition& position);

// Longitude and latitude on WGS 84, degrees, in this order, as GeoJSON has them.
inline constexpr int kLongitudeLatitudeEpsg = 4326;

// Returns whether an EPSG code is that of longitude and latitude or of a UTM zone, on WGS 84.
bool is_wgs84(int epsg);

// Returns points of one such coordinate system as (easting, northing) [m] in the UTM zone
// `utm_epsg`. Throws Error{BadData} if a point has no place in it.
std::vector<Eigen::Vector2d> to_utm(const std::vector<Eigen::Vector2d>& points,
                                    int epsg,
                                    int utm_epsg);

}  // namespace divemesh::io
