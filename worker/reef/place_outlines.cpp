#include "worker/reef/place_outlines.hpp"

#include <Eigen/LU>
#include <cmath>

#include "schemas/error.hpp"
#include "worker/base/text.hpp"
#include "worker/io/exports.hpp"
#include "worker/io/geographic_frame.hpp"
#include "worker/io/mosaic_files.hpp"

namespace divemesh::reef {
namespace {

void place_from_earth(OutlineFile& file, const io::ReconstructionFolder& reconstruction) {
    const auto position = io::position_of(reconstruction);
    if (!position)
        throw Error(ErrorCode::InvalidArgument,
                    "its coordinates are " + coordinates_text(file) +
                        ", and the position of the dive is not known: write position into its "
                        "dive.json, or, if they are metres in the world of the reconstruction, "
                        "give --areas-crs world");
    const io::UtmFrame utm = io::utm_frame(*position);
    const Eigen::Matrix2d world_from_utm = utm.A.leftCols<2>().inverse();
    for (Outline& outline : file.outlines) {
        outline.points = io::to_utm(outline.points, file.epsg, utm.epsg);
        for (Eigen::Vector2d& point : outline.points)
            point = world_from_utm * (point - utm.A.col(2));
    }
}

std::string size_text(const Eigen::Vector2d& size_px) {
    return base::fixed(size_px.x(), 0) + " x " + base::fixed(size_px.y(), 0) + " pixels";
}

// Returns the side of a pixel of the image that was drawn on, m. It may be the mosaic in another
// resolution, but not another image.
double drawn_pixel_m(const OutlineFile& file, const types::RasterGrid& mosaic) {
    constexpr double kMaxScaleError = 0.01;  // of a pixel size that a person typed
    const Eigen::Vector2d drawn_px = file.image_size_px;
    if (!(drawn_px.minCoeff() >= 1.0)) return mosaic.pixel_m;
    const Eigen::Vector2d mosaic_px(mosaic.width_px, mosaic.height_px);
    const Eigen::Vector2d ratio = mosaic_px.cwiseQuotient(drawn_px);
    const double rounding = 1.0 / std::min(mosaic_px.minCoeff(), drawn_px.minCoeff());
    if (std::abs(ratio.x() / ratio.y() - 1.0) > rounding)
        throw Error(ErrorCode::BadData,
                    "it was drawn on an image of " + size_text(drawn_px) +
                        ", but the mosaic of this reconstruction has " + size_text(mosaic_px) +
                        ": draw on this mosaic");
    const double pixel_m = mosaic.pixel_m * ratio.x();
    if (file.pixel_m > 0.0 && std::abs(file.pixel_m / pixel_m - 1.0) > kMaxScaleError)
        throw Error(ErrorCode::BadData,
                    "it states " + base::significant(1e3 * file.pixel_m) +
                        " mm a pixel, but a pixel of the mosaic is " +
                        base::significant(1e3 * pixel_m) +
                        " mm: draw on this mosaic, or correct the pixel size of the map");
    return pixel_m;
}

void place_from_pixels(OutlineFile& file, const io::ReconstructionFolder& reconstruction) {
    const types::RasterGrid mosaic =
        io::mosaic_grid_of(reconstruction.mosaic(), reconstruction.path() / "mosaic.json");
    const Eigen::Vector2d corner_m(mosaic.corner_x_m, mosaic.corner_y_m);
    const double pixel_m = drawn_pixel_m(file, mosaic);
    for (Outline& outline : file.outlines)
        for (Eigen::Vector2d& point : outline.points)
            point = corner_m + pixel_m * Eigen::Vector2d(point.x() + 0.5, -point.y() - 0.5);
}

}  // namespace

std::string coordinates_text(const OutlineFile& file) {
    switch (file.coordinates) {
        case OutlineCoordinates::Earth:
            return file.epsg == io::kLongitudeLatitudeEpsg
                       ? "longitude and latitude"
                       : "those of EPSG:" + std::to_string(file.epsg);
        case OutlineCoordinates::Pixels: return "pixels of the mosaic";
        default: return "metres in the world of the reconstruction";
    }
}

void place_outlines(OutlineFile& file, const io::ReconstructionFolder& reconstruction) {
    if (file.coordinates == OutlineCoordinates::Earth) place_from_earth(file, reconstruction);
    if (file.coordinates == OutlineCoordinates::Pixels) place_from_pixels(file, reconstruction);
}

}  // namespace divemesh::reef
