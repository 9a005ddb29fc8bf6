#pragma once

#include <opencv2/core/mat.hpp>

#include "worker/io/raster_frame.hpp"
#include "worker/io/tiff_directory.hpp"

namespace divemesh::io {

// Sets the tags of a tiled raster of CV_8UC4 or CV_32F, apart from where its tiles lie.
void set_raster_tags(TiffDirectory& directory, const cv::Size& size, int type, int tile_px);

// Sets the tags of GeoTIFF 1.0 (OGC 19-008). A local frame has a user-defined coordinate system in
// metres.
void set_frame_tags(TiffDirectory& directory, const RasterFrame& frame);

}  // namespace divemesh::io
