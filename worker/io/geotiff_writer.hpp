#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <opencv2/core/mat.hpp>
#include <string>

namespace divemesh::io {

// Georeference of a raster: (easting, northing) [m] of the coordinate system `epsg` = A * (column,
// row, 1); pixel (0, 0) has its outer corner at (0, 0).
struct RasterFrame {
    int epsg = 0;  // of a projected coordinate system
    Eigen::Matrix<double, 2, 3> A = Eigen::Matrix<double, 2, 3>::Zero();
    std::string citation;  // human-readable name
};

// Writes a GeoTIFF 1.0, tiled, deflated. CV_8UC4 (BGRA) becomes RGB with unassociated alpha, CV_32F
// one band with NaN for no data. Throws as write_file does, and Error{InvalidArgument} for other
// types.
void write_geotiff(const std::filesystem::path& file,
                   const cv::Mat& raster,
                   const RasterFrame& frame);

}  // namespace divemesh::io
