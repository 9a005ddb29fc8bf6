#include "worker/io/raster_frame.hpp"

#include <cstdio>
#include <sstream>

#include "worker/io/geographic_frame.hpp"

namespace divemesh::io {
namespace {

std::string utm_citation(const types::GeographicPosition& position) {
    std::ostringstream text;
    text.precision(9);
    text << "WGS 84 / UTM; origin at latitude " << position.latitude_deg << ", longitude "
         << position.longitude_deg;
    if (position.x_azimuth_deg)
        text << ", x axis at azimuth " << *position.x_azimuth_deg;
    else
        text << ", NORTH NOT KNOWN: y axis taken for it";
    return text.str();
}

}  // namespace

RasterFrame raster_frame(const types::RasterGrid& grid,
                         const std::optional<types::GeographicPosition>& position) {
    Eigen::Matrix3d T_world_pixel;  // of (column, row, 1)
    // clang-format off
    T_world_pixel << grid.pixel_m, 0.0, grid.corner_x_m,
                     0.0, -grid.pixel_m, grid.corner_y_m,
                     0.0, 0.0, 1.0;
    // clang-format on
    if (!position) return {RasterFrame::kLocal, T_world_pixel.topRows<2>(), "local, metres, z up"};
    const UtmFrame utm = utm_frame(*position);
    return {utm.epsg, utm.A * T_world_pixel, utm_citation(*position)};
}

std::string world_file(const RasterFrame& frame) {
    const auto& A = frame.A;
    const Eigen::Vector2d centre = A * Eigen::Vector3d(0.5, 0.5, 1.0);
    std::string text;
    for (const double value : {A(0, 0), A(1, 0), A(0, 1), A(1, 1), centre.x(), centre.y()}) {
        char line[40];
        std::snprintf(line, sizeof line, "%.12g\n", value);
        text += line;
    }
    return text;
}

}  // namespace divemesh::io
