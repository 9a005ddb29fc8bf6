#pragma once

#include <string>

#include "worker/recording/image_file.hpp"

namespace divemesh::recording {

// What a user says about the pixels of images.
struct PixelOptions {
    std::string bayer;  // "rggb", "bggr", "gbrg" or "grbg": the images are such a mosaic; "": not
    int num_bits = 0;   // that are used of 16, from the lowest on; 0: all of them
};

// Returns an image file as a dive stores it: a PNG or JPEG to the byte, a TIFF, BMP, PGM or PPM as
// a PNG with the same pixels, without transparency. A Bayer mosaic is interpolated to colour.
// Values of fewer bits than 8 or 16 are moved up to fill them. Throws Error{BadData} with the
// reason if the image is damaged, of another format, or larger than dives may be.
ImageFile stored_image(std::string bytes, const PixelOptions& options);

}  // namespace divemesh::recording
