#pragma once

#include <cstdint>
#include <filesystem>
#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

#include "worker/base/scratch_file.hpp"
#include "worker/io/raster_frame.hpp"
#include "worker/io/tiff_directory.hpp"

namespace divemesh::io {

// Writes a raster by rows as a cloud-optimised GeoTIFF 1.0: tiled, deflated, with overviews of half
// the size each (means of what is known), directories first and overviews before the whole.
// CV_8UC4 (BGRA) becomes RGB with unassociated alpha, CV_32F one band with NaN for no data. In
// memory are two rows of tiles; the packed tiles wait in a scratch file beside `file`, which
// appears complete with commit(). A file of more than 4 GiB is a BigTIFF. Threads do not change its
// bytes. Throws as AtomicFile and ScratchFile do, and Error{InvalidArgument} for other types.
class GeotiffWriter {
public:
    GeotiffWriter(const std::filesystem::path& file,
                  const cv::Size& size,
                  int type,
                  const RasterFrame& frame,
                  int num_threads);

    void append(const cv::Mat& rows);  // as wide as the raster
    void commit();                     // after the last row

private:
    struct StoredTile {
        std::uint64_t scratch_offset = 0;
        std::uint32_t num_bytes = 0;  // with leader and trailer
    };
    // The raster, or an overview of it.
    struct Level {
        cv::Size size;
        cv::Mat rows;  // of the row of tiles in work
        int num_rows = 0;
        int num_finished_rows = 0;
        std::vector<StoredTile> tiles;  // row by row
    };

    void append_to(std::size_t level, const cv::Mat& rows);
    void finish_tiles(std::size_t level);
    std::vector<std::string> packed_tiles(const cv::Mat& rows) const;
    TiffDirectory directory(std::size_t level, std::uint64_t first_tile, TiffVariant variant) const;
    std::string head(TiffVariant variant) const;

    std::filesystem::path file_;
    int type_;
    RasterFrame frame_;
    int num_threads_;
    std::string empty_tile_;  // packed
    std::vector<Level> levels_;
    base::ScratchFile scratch_;
    std::uint64_t scratch_bytes_ = 0;
};

}  // namespace divemesh::io
