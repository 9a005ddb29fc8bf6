#pragma once

#include <Eigen/Core>

#include "worker/types/geographic_position.hpp"

namespace divemesh::io {

// The world's horizontal plane in Universal Transverse Mercator: (easting, northing) [m] =
// A * (x, y, 1). Turned by the meridian's convergence and stretched by the projection's scale at
// the origin; over 500 m both change by less than a millimetre's worth.
struct UtmFrame {
    int epsg = 0;  // 326zz north, 327zz south of the equator
    Eigen::Matrix<double, 2, 3> A = Eigen::Matrix<double, 2, 3>::Zero();
};

// A world whose azimuth is not known is taken to have its y axis to the north. Throws
// Error{InvalidArgument} for a position that is not valid.
UtmFrame utm_frame(const types::GeographicPosition& position);

}  // namespace divemesh::io
