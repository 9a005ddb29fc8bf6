#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>
#include <vector>

#include "worker/io/geotiff_writer.hpp"
#include "worker/io/mosaic_preview.hpp"
#include "worker/io/raster_frame.hpp"
#include "worker/types/geographic_position.hpp"
#include "worker/types/raster_grid.hpp"

namespace divemesh::io {

// Writes the files of a mosaic to `folder`, by rows:
//   mosaic.tif, heights.tif, heights_sigma.tif   GeoTIFFs, in UTM with a position, else local
//   mosaic.tfw, heights.tfw                      their world files
//   mosaic.png, mosaic.pgw   a preview of at most 4096 pixels a side, placed in the world frame
//   mosaic.json              the pixels of preview and GeoTIFFs in the world frame
// A few hundred rows are in memory. Throws as GeotiffWriter does.
class MosaicWriter {
public:
    MosaicWriter(const std::filesystem::path& folder,
                 const types::RasterGrid& grid,
                 const std::optional<types::GeographicPosition>& position,
                 int num_threads);

    // Takes the next rows: CV_8UC4 BGRA, alpha 0 where there is no surface; heights and their
    // standard deviation, CV_32F, m, NaN where there is none.
    void append(const cv::Mat& color, const cv::Mat& height_m, const cv::Mat& sigma_m);
    void commit();  // after the last row

    const cv::Mat& preview() const { return preview_.image(); }  // CV_8UC4 BGRA

private:
    std::filesystem::path folder_;
    types::RasterGrid grid_;
    RasterFrame frame_;
    GeotiffWriter color_;
    GeotiffWriter heights_;
    GeotiffWriter sigma_;
    MosaicPreview preview_;
};

// Returns the pixels of the GeoTIFFs, as mosaic.json describes them. Throws Error{BadData} with the
// file's name if it does not.
types::RasterGrid mosaic_grid_of(const nlohmann::json& description,
                                 const std::filesystem::path& file);

// Copies the three GeoTIFFs of the reconstruction in `folder` to `out`, with their place from
// `position`, and writes their world files; returns the names. Throws as RasterReader and
// GeotiffWriter do.
std::vector<std::string> copy_mosaic(const std::filesystem::path& folder,
                                     const types::RasterGrid& grid,
                                     const types::GeographicPosition& position,
                                     const std::filesystem::path& out);

}  // namespace divemesh::io
