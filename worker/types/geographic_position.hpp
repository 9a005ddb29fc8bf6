#pragma once

#include <cmath>
#include <optional>

namespace divemesh::types {

// Where the world's origin lies on the earth (WGS 84), and the heading of the world frame.
struct GeographicPosition {
    double latitude_deg = 0.0;
    double longitude_deg = 0.0;
    // Azimuth of the world's x axis, clockwise from true north; nullopt: unknown.
    std::optional<double> x_azimuth_deg;

    // Returns true for latitudes -80 to 84 (what UTM covers), longitudes -180 to 180 and a finite
    // azimuth.
    bool is_valid() const {
        return latitude_deg >= -80.0 && latitude_deg <= 84.0 && longitude_deg >= -180.0 &&
               longitude_deg <= 180.0 && std::isfinite(x_azimuth_deg.value_or(0.0));
    }
};

}  // namespace divemesh::types
