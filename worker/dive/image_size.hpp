#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "worker/dive/dive_contents.hpp"
#include "worker/dive/dive_files.hpp"
#include "worker/dive/finding_log.hpp"
#include "worker/types/camera.hpp"

namespace divemesh::dive {

struct ImageSize {
    std::int64_t width_px = 0;
    std::int64_t height_px = 0;

    bool operator==(const ImageSize&) const = default;
};

// Returns "640x480".
std::string to_string(const ImageSize& size);

// The images of a camera as a part of those that it was calibrated with: `scale` times their size,
// cut in the middle to `size`.
struct ImagePart {
    ImageSize size;
    double scale = 1.0;
};

// Returns the largest part of the calibrated image that has this size. nullopt if the images would
// have to be larger than the calibrated ones in one direction and smaller in the other, or are
// larger and cut too: then the sizes alone do not tell what they show.
std::optional<ImagePart> part_of(const types::Camera& calibrated, const ImageSize& size);

// Returns the calibration of the images that are a part of those of a camera.
types::Camera camera_of(const types::Camera& calibrated, const ImagePart& part);

// Adapts the calibration if all images of both cameras have one other size than the calibrated one,
// as of a video mode that scales or cuts the image, and warns that it did. Otherwise nothing
// changes.
void adapt_to_image_size(const DiveFiles& files, DiveContents& contents, FindingLog& findings);

}  // namespace divemesh::dive
