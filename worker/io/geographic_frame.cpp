#include "worker/io/geographic_frame.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <proj.h>
#include <string>

#include "schemas/error.hpp"
#include "worker/base/angle.hpp"

namespace divemesh::io {
namespace {

constexpr double kNorthIsY_deg = 90.0;

struct Destroy {
    void operator()(PJ_CONTEXT* context) const { proj_context_destroy(context); }
    void operator()(PJ* projection) const { proj_destroy(projection); }
};

int zone_of(double longitude_deg) {
    return std::clamp(static_cast<int>(std::floor((longitude_deg + 180.0) / 6.0)) + 1, 1, 60);
}

}  // namespace

UtmFrame utm_frame(const types::GeographicPosition& position) {
    if (!position.is_valid())
        throw Error(ErrorCode::InvalidArgument,
                    "the position is outside of UTM: give a latitude from -80 to 84 and a "
                    "longitude from -180 to 180 degrees");
    const int zone = zone_of(position.longitude_deg);
    const bool south = position.latitude_deg < 0.0;
    const std::unique_ptr<PJ_CONTEXT, Destroy> context(proj_context_create());
    const std::string definition =
        "+proj=utm +ellps=WGS84 +zone=" + std::to_string(zone) + (south ? " +south" : "");
    const std::unique_ptr<PJ, Destroy> utm(proj_create(context.get(), definition.c_str()));
    if (!utm) throw Error(ErrorCode::Unavailable, "PROJ does not know " + definition);
    const PJ_COORD place = proj_coord(
        position.longitude_deg * base::kRadPerDeg, position.latitude_deg * base::kRadPerDeg, 0, 0);
    const PJ_COORD origin = proj_trans(utm.get(), PJ_FWD, place);
    const PJ_FACTORS factors = proj_factors(utm.get(), place);
    const double x_bearing = position.x_azimuth_deg.value_or(kNorthIsY_deg) * base::kRadPerDeg -
                             factors.meridian_convergence;
    const double scale = factors.meridional_scale;
    const double sin = scale * std::sin(x_bearing);
    const double cos = scale * std::cos(x_bearing);
    UtmFrame frame;
    frame.epsg = (south ? 32700 : 32600) + zone;
    frame.A << sin, -cos, origin.enu.e, cos, sin, origin.enu.n;
    return frame;
}

}  // namespace divemesh::io
