#include "worker/mosaic/thumbnail.hpp"

#include <algorithm>
#include <cstdint>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

namespace divemesh::mosaic {

std::string thumbnail_png(const cv::Mat& color, int max_side_px) {
    cv::Mat image(color.size(), CV_8UC3);
    for (int row = 0; row < image.rows; ++row)
        for (int column = 0; column < image.cols; ++column) {
            const auto& pixel = color.at<cv::Vec4b>(row, column);
            image.at<cv::Vec3b>(row, column) =
                pixel[3] == 0 ? cv::Vec3b(255, 255, 255) : cv::Vec3b(pixel[0], pixel[1], pixel[2]);
        }
    const double scale = static_cast<double>(max_side_px) / std::max(image.rows, image.cols);
    if (scale < 1.0) cv::resize(image, image, {}, scale, scale, cv::INTER_AREA);
    std::vector<std::uint8_t> png;
    cv::imencode(".png", image, png);
    return {png.begin(), png.end()};
}

}  // namespace divemesh::mosaic
