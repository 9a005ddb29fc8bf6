#pragma once

#include <cmath>
#include <optional>

namespace divemesh::types {

// Where the world's origin lies on the earth, WGS 84, and how the world is turned.
struct GeographicPosition {
    double latitude_deg = 0.0;
    double longitude_deg = 0.0;
    // Of the world's x axis, clockwise from true north; nothing: not known.
    std::optional<double> x_azimuth_deg;

    // Latitude -80 to 84 (what UTM covers), longitude -180 to 180.
    bool is_valid() const {
        return latitude_deg >= -80.0 && latitude_deg <= 84.0 && longitude_deg >= -180.0 &&
               longitude_deg <= 180.0 && std::isfinite(x_azimuth_deg.value_or(0.0));
    }
};

}  // namespace divemesh::types
