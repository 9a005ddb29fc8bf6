#pragma once

#include <opencv2/core/mat.hpp>

#include "worker/color/keyframe_view.hpp"
#include "worker/types/keyframe.hpp"

namespace divemesh::color {

// The surface as a keyframe sees it, pixel by pixel. Pixels without surface have the values of the
// nearest pixel with one. Kept at half the size of the image, as both change slowly.
class SurfaceImages {
public:
    SurfaceImages(const SeenSurface& surface, const types::Keyframe& keyframe);

    struct Pixel {
        float range_m = 0.0F;  // along the ray; 0 if the keyframe sees no surface
        // Cosine of the angle between normal and ray; smooth within one surface, so that shading
        // by it has no facets.
        float cosine = 1.0F;
    };
    // Returns the surface in a pixel of the image.
    Pixel at(int row, int column) const;

private:
    mesh::ImageCamera camera_;  // of the image
    float scale_ = 1.0F;
    cv::Mat surface_;  // CV_32FC2: inverse depth, cosine; empty if there is no surface
};

}  // namespace divemesh::color
