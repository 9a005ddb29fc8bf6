#pragma once

#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <string>
#include <string_view>

namespace divemesh::dive {

constexpr std::int64_t kMaxImageFileBytes = std::int64_t{64} << 20;

enum class ImageFormat { Png, Jpeg };

// The properties of an image according to its first bytes, read without decoding it.
struct ImageHeader {
    ImageFormat format = ImageFormat::Png;
    std::int64_t width_px = 0;
    std::int64_t height_px = 0;
    int num_channels = 0;  // 1 or 3: grey or colour, without alpha
    int bits_per_channel = 8;
};

// Throws Error{BadData} if the file ends early or is not a PNG or JPEG that can be decoded.
ImageHeader read_image_header(std::string_view bytes);

enum class Channels { Grey, Bgr };

// Returns the image with 8 bits per channel; 16 bits are reduced to the upper 8. With a `reduction`
// of 2, 4 or 8 it has that part of its size, rounded down; a JPEG is decoded at that size. The
// caller must have checked the size in the header. Throws Error{BadData} if decoding fails.
cv::Mat decode_image(std::string_view bytes,
                     const ImageHeader& header,
                     Channels channels,
                     int reduction = 1);

}  // namespace divemesh::dive
