#pragma once

#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <string>
#include <string_view>

namespace divemesh::dive {

enum class ImageFormat { Png, Jpeg };

// What the first bytes of a picture promise, read without decoding it.
struct ImageHeader {
    ImageFormat format = ImageFormat::Png;
    std::int64_t width_px = 0;
    std::int64_t height_px = 0;
    int num_channels = 0;  // 1 or 3: grey or colour; an alpha channel is not counted
    int bits_per_channel = 8;
};

// Throws Error{BadData} for what is not a PNG or JPEG that we decode, and for a file that ends
// early.
ImageHeader read_image_header(std::string_view bytes);

enum class Channels { Grey, Bgr };

// 8 bit; 16 bits are reduced to the upper 8. The caller has found the size in the header
// acceptable. Throws Error{BadData} when it does not decode.
cv::Mat decode_image(std::string_view bytes, const ImageHeader& header, Channels channels);

}  // namespace divemesh::dive
