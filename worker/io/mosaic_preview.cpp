#include "worker/io/mosaic_preview.hpp"

#include <algorithm>

namespace divemesh::io {
namespace {

int divided_up(int number, int divisor) { return (number + divisor - 1) / divisor; }

}  // namespace

MosaicPreview::MosaicPreview(const types::RasterGrid& whole, int max_side_px)
    : factor_(divided_up(std::max(whole.width_px, whole.height_px), max_side_px)),
      num_rows_left_(whole.height_px),
      grid_(whole) {
    grid_.width_px = divided_up(whole.width_px, factor_);
    grid_.height_px = divided_up(whole.height_px, factor_);
    grid_.pixel_m = whole.pixel_m * factor_;
    sums_ = cv::Mat(1, grid_.width_px, CV_32SC4, cv::Scalar::all(0));
    image_ = cv::Mat(grid_.height_px, grid_.width_px, CV_8UC4, cv::Scalar::all(0));
}

void MosaicPreview::append(const cv::Mat& color) {
    for (int row = 0; row < color.rows; ++row) {
        for (int column = 0; column < color.cols; ++column) {
            const auto& pixel = color.at<cv::Vec4b>(row, column);
            if (pixel[3] == 0) continue;
            auto& sum = sums_.at<cv::Vec4i>(0, column / factor_);
            sum += cv::Vec4i(pixel[0], pixel[1], pixel[2], 1);
        }
        --num_rows_left_;
        if (++num_summed_rows_ == factor_ || num_rows_left_ == 0) finish_row();
    }
}

void MosaicPreview::finish_row() {
    for (int column = 0; column < grid_.width_px; ++column) {
        auto& sum = sums_.at<cv::Vec4i>(0, column);
        const int count = sum[3];
        if (count == 0) continue;
        auto& pixel = image_.at<cv::Vec4b>(next_row_, column);
        for (int channel = 0; channel < 3; ++channel)
            pixel[channel] = static_cast<std::uint8_t>((sum[channel] + count / 2) / count);
        pixel[3] = 255;
        sum = {};
    }
    num_summed_rows_ = 0;
    ++next_row_;
}

}  // namespace divemesh::io
