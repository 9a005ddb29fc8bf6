#include "worker/io/jpeg.hpp"

#include <opencv2/imgcodecs.hpp>

#include "schemas/error.hpp"

namespace divemesh::io {

std::string encode_jpeg(const cv::Mat& image) {
    std::vector<std::uint8_t> bytes;
    if (!cv::imencode(".jpg", image, bytes, {cv::IMWRITE_JPEG_QUALITY, kJpegQuality}))
        throw Error(ErrorCode::Unavailable,
                    "cannot encode an image of " + std::to_string(image.cols) + " x " +
                        std::to_string(image.rows) + " px as JPEG: free memory");
    return {bytes.begin(), bytes.end()};
}

}  // namespace divemesh::io
