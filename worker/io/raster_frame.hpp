#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>

#include "worker/types/geographic_position.hpp"
#include "worker/types/raster_grid.hpp"

namespace divemesh::io {

// Where the pixels of a raster lie: (x, y) [m] of the coordinate system = A * (column, row, 1);
// pixel (0, 0) has its outer corner at (0, 0).
struct RasterFrame {
    static constexpr int kLocal = 0;

    int epsg = kLocal;  // of a projected coordinate system; kLocal: metres in the world frame
    Eigen::Matrix<double, 2, 3> A = Eigen::Matrix<double, 2, 3>::Zero();
    std::string citation;  // human-readable name
};

// Returns the frame of a mosaic: in UTM with a position, local without one.
RasterFrame raster_frame(const types::RasterGrid& grid,
                         const std::optional<types::GeographicPosition>& position);

// Returns the six lines of an ESRI world file: the (x, y) of a pixel's centre is (A column + B row
// + C, D column + E row + F), in the order A D B E C F.
std::string world_file(const RasterFrame& frame);

}  // namespace divemesh::io
