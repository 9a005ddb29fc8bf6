#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>
#include <vector>

#include "worker/base/observer.hpp"
#include "worker/mosaic/mosaic_grid.hpp"
#include "worker/mosaic/mosaic_renderer.hpp"
#include "worker/types/geographic_position.hpp"

namespace divemesh::io {

// Writes the files of a mosaic to `folder`:
//   mosaic.tif, heights.tif, heights_sigma.tif   GeoTIFFs, in UTM with a position, else local
//   mosaic.tfw, heights.tfw                      their world files
//   mosaic.png, mosaic.pgw   a preview of at most 4096 pixels a side, placed in the world frame
//   mosaic.json              the pixels of preview and GeoTIFFs in the world frame
// Returns the preview, CV_8UC4 BGRA. In memory are a few hundred rows. Throws as GeotiffWriter
// does.
cv::Mat write_mosaic(const std::filesystem::path& folder,
                     const mosaic::MosaicRenderer& renderer,
                     const std::optional<types::GeographicPosition>& position,
                     const base::ProgressCallback& progress = base::ignore_progress);

// Returns the pixels of the GeoTIFFs, as mosaic.json describes them. Throws Error{BadData} with the
// file's name if it does not.
mosaic::MosaicGrid mosaic_grid_of(const nlohmann::json& description,
                                  const std::filesystem::path& file);

// Copies the three GeoTIFFs of the reconstruction in `folder` to `out`, with their place from
// `position`, and writes their world files; returns the names. Throws as RasterReader and
// GeotiffWriter do.
std::vector<std::string> copy_mosaic(const std::filesystem::path& folder,
                 const mosaic::MosaicGrid& grid,
                 const types::GeographicPosition& position,
                 const std::filesystem::path& out);

}  // namespace divemesh::io
