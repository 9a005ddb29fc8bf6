#pragma once

#include <string>

#include "worker/dive/image.hpp"
#include "worker/recording/messages.hpp"

namespace divemesh::recording {

// An image as a file of a dive.
struct ImageFile {
    std::string bytes;
    dive::ImageHeader header;

    const char* extension() const {
        return header.format == dive::ImageFormat::Png ? ".png" : ".jpg";
    }
};

// Returns an image as a PNG with the same pixels: grey of 8 or 16 bits, or colour. A Bayer mosaic
// is interpolated to colour. Throws Error{BadData} with the reason if the encoding is not read or
// the sizes contradict each other.
ImageFile image_file(const RawImage& image);

// Returns a compressed image as it is. Throws Error{BadData} if it is neither PNG nor JPEG.
ImageFile image_file(const CompressedImage& image);

}  // namespace divemesh::recording
