#pragma once

#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "worker/types/geographic_position.hpp"
#include "worker/video/gpmf.hpp"

namespace divemesh::video {

// A position that a GPS measured, WGS 84.
struct GpsFix {
    double latitude_deg = 0.0;
    double longitude_deg = 0.0;
};

// Returns the fixes of a payload that are locked and precise: those of GPS9, or of GPS5 where the
// camera does not write it. Under water there are none.
std::vector<GpsFix> parse_gps(std::string_view bytes);

// Where a camera was at the surface.
struct GpsPosition {
    types::GeographicPosition position;  // median of the fixes, without azimuth
    std::int64_t num_fixes = 0;
    double scatter_m = 0.0;  // half of the fixes are this near
    double spread_m = 0.0;   // 95 % of them are
};

// Returns the position of a recording; nullopt without a fix that GeographicPosition can state.
std::optional<GpsPosition> gps_position_of(const std::vector<GpmfPayload>& payloads);

}  // namespace divemesh::video
