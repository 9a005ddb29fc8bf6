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
constexpr int kNorthernUtm = 32600;  // the EPSG code of its zone 0, which does not exist
constexpr int kSouthernUtm = 32700;

struct Destroy {
    void operator()(PJ_CONTEXT* context) const { proj_context_destroy(context); }
    void operator()(PJ* projection) const { proj_destroy(projection); }
};

int zone_of(double longitude_deg) {
    return std::clamp(static_cast<int>(std::floor((longitude_deg + 180.0) / 6.0)) + 1, 1, 60);
}

bool is_utm(int epsg) {
    const int zone = epsg - (epsg > kSouthernUtm ? kSouthernUtm : kNorthernUtm);
    return zone >= 1 && zone <= 60;
}

void check_position(const types::GeographicPosition& position) {
    if (!position.is_valid())
        throw Error(ErrorCode::InvalidArgument,
                    "the position is outside of UTM: give a latitude from -80 to 84 and a "
                    "longitude from -180 to 180 degrees");
}

using Projection = std::unique_ptr<PJ, Destroy>;

Projection utm_projection(PJ_CONTEXT* context, int epsg) {
    const bool south = epsg > kSouthernUtm;
    const std::string definition = "+proj=utm +ellps=WGS84 +zone=" +
                                   std::to_string(epsg - (south ? kSouthernUtm : kNorthernUtm)) +
                                   (south ? " +south" : "");
    Projection utm(proj_create(context, definition.c_str()));
    if (!utm) throw Error(ErrorCode::Unavailable, "PROJ does not know " + definition);
    return utm;
}

}  // namespace

UtmFrame utm_frame(const types::GeographicPosition& position) {
    return utm_frame(position,
                     (position.latitude_deg < 0.0 ? kSouthernUtm : kNorthernUtm) +
                         zone_of(position.longitude_deg));
}

UtmFrame utm_frame(const types::GeographicPosition& position, int utm_epsg) {
    check_position(position);
    UtmFrame frame;
    frame.epsg = utm_epsg;
    const std::unique_ptr<PJ_CONTEXT, Destroy> context(proj_context_create());
    const Projection utm = utm_projection(context.get(), frame.epsg);
    const PJ_COORD place = proj_coord(
        position.longitude_deg * base::kRadPerDeg, position.latitude_deg * base::kRadPerDeg, 0, 0);
    const PJ_COORD origin = proj_trans(utm.get(), PJ_FWD, place);
    const PJ_FACTORS factors = proj_factors(utm.get(), place);
    const double x_bearing = position.x_azimuth_deg.value_or(kNorthIsY_deg) * base::kRadPerDeg -
                             factors.meridian_convergence;
    const double scale = factors.meridional_scale;
    const double sin = scale * std::sin(x_bearing);
    const double cos = scale * std::cos(x_bearing);
    frame.A << sin, -cos, origin.enu.e, cos, sin, origin.enu.n;
    return frame;
}

types::GeographicPosition geographic_position(const Eigen::Vector2d& utm_m, int utm_epsg) {
    const std::unique_ptr<PJ_CONTEXT, Destroy> context(proj_context_create());
    const Projection utm = utm_projection(context.get(), utm_epsg);
    const PJ_COORD place = proj_trans(utm.get(), PJ_INV, proj_coord(utm_m.x(), utm_m.y(), 0, 0));
    const types::GeographicPosition position{
        place.lp.phi * base::kDegPerRad, place.lp.lam * base::kDegPerRad, std::nullopt};
    if (!position.is_valid())
        throw Error(ErrorCode::BadData,
                    "the place " + std::to_string(utm_m.x()) + ", " + std::to_string(utm_m.y()) +
                        " of EPSG:" + std::to_string(utm_epsg) + " is outside of UTM");
    return position;
}

Eigen::Isometry3d earth_from_world(const types::GeographicPosition& position) {
    constexpr double kEquatorRadius_m = 6378137.0;  // WGS 84
    constexpr double kFlattening = 1.0 / 298.257223563;
    constexpr double kEccentricity2 = kFlattening * (2.0 - kFlattening);
    check_position(position);
    const double latitude = position.latitude_deg * base::kRadPerDeg;
    const double longitude = position.longitude_deg * base::kRadPerDeg;
    const Eigen::Vector3d up(std::cos(latitude) * std::cos(longitude),
                             std::cos(latitude) * std::sin(longitude),
                             std::sin(latitude));
    const Eigen::Vector3d east(-std::sin(longitude), std::cos(longitude), 0.0);
    const Eigen::Vector3d north = up.cross(east);
    const double azimuth = position.x_azimuth_deg.value_or(kNorthIsY_deg) * base::kRadPerDeg;
    const double prime_vertical_m =
        kEquatorRadius_m / std::sqrt(1.0 - kEccentricity2 * up.z() * up.z());
    Eigen::Isometry3d T_earth_world = Eigen::Isometry3d::Identity();
    T_earth_world.linear().col(0) = std::sin(azimuth) * east + std::cos(azimuth) * north;
    T_earth_world.linear().col(1) = std::sin(azimuth) * north - std::cos(azimuth) * east;
    T_earth_world.linear().col(2) = up;
    T_earth_world.translation() = prime_vertical_m * up;
    T_earth_world.translation().z() *= 1.0 - kEccentricity2;
    return T_earth_world;
}

bool is_wgs84(int epsg) { return epsg == kLongitudeLatitudeEpsg || is_utm(epsg); }

std::vector<Eigen::Vector2d> to_utm(const std::vector<Eigen::Vector2d>& points,
                                    int epsg,
                                    int utm_epsg) {
    if (epsg == utm_epsg) return points;
    const std::unique_ptr<PJ_CONTEXT, Destroy> context(proj_context_create());
    const Projection to = utm_projection(context.get(), utm_epsg);
    const Projection from = is_utm(epsg) ? utm_projection(context.get(), epsg) : nullptr;
    std::vector<Eigen::Vector2d> projected;
    for (const Eigen::Vector2d& point : points) {
        const PJ_COORD place =
            from ? proj_trans(from.get(), PJ_INV, proj_coord(point.x(), point.y(), 0, 0))
                 : proj_coord(point.x() * base::kRadPerDeg, point.y() * base::kRadPerDeg, 0, 0);
        const PJ_COORD utm = proj_trans(to.get(), PJ_FWD, place);
        if (!std::isfinite(utm.enu.e) || !std::isfinite(utm.enu.n))
            throw Error(ErrorCode::BadData,
                        "the coordinates " + std::to_string(point.x()) + ", " +
                            std::to_string(point.y()) +
                            " have no place in EPSG:" + std::to_string(utm_epsg) +
                            ": check their coordinate system, or --areas-crs");
        projected.emplace_back(utm.enu.e, utm.enu.n);
    }
    return projected;
}

}  // namespace divemesh::io
