#pragma once

#include <opencv2/core/mat.hpp>

#include "worker/types/raster_grid.hpp"

namespace divemesh::io {

// A smaller image of a mosaic, made while that is rendered: each pixel is the mean of a square of
// the mosaic's that show surface.
class MosaicPreview {
public:
    MosaicPreview(const types::RasterGrid& whole, int max_side_px);

    // Takes the next rows (CV_8UC4 BGRA) of the mosaic.
    void append(const cv::Mat& color);

    const types::RasterGrid& grid() const { return grid_; }
    const cv::Mat& image() const { return image_; }  // CV_8UC4 BGRA, complete after the last row

private:
    void finish_row();

    int factor_;  // pixels of the mosaic along a side of the square
    int num_rows_left_;
    types::RasterGrid grid_;
    cv::Mat sums_;  // CV_32SC4 of the row in work: b g r, number of pixels
    int num_summed_rows_ = 0;
    int next_row_ = 0;
    cv::Mat image_;
};

}  // namespace divemesh::io
