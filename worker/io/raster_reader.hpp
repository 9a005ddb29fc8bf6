#pragma once

#include <filesystem>
#include <limits>
#include <memory>
#include <opencv2/core/mat.hpp>

struct tiff;

namespace divemesh::io {

// Reads a GeoTIFF of GeotiffWriter by rows: the whole raster, or the largest overview of at most
// `max_side_px`. Throws Error{NotFound} if there is no such file, Error{BadData} for any other
// file, and for a broken one.
class RasterReader {
public:
    explicit RasterReader(const std::filesystem::path& file,
                          int max_side_px = std::numeric_limits<int>::max());

    const cv::Size& size() const { return size_; }
    int type() const { return type_; }  // CV_8UC4 (BGRA) or CV_32F
    cv::Mat rows(int first_row, int num_rows);

private:
    void read_layout();
    [[noreturn]] void fail() const;

    std::filesystem::path file_;
    std::unique_ptr<tiff, void (*)(tiff*)> tiff_;
    cv::Size size_;
    int type_ = 0;
    int tile_px_ = 0;
};

}  // namespace divemesh::io
