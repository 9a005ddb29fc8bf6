#pragma once

#include <opencv2/core/mat.hpp>

namespace divemesh::texture {

// What remains to be added to the pixels of an image along seams.
struct SeamResiduals {
    explicit SeamResiduals(const cv::Size& size);

    cv::Mat sums;     // CV_32FC3, weighted
    cv::Mat weights;  // CV_32F; 0 where there is no seam
};

// Adds the residuals along the seams to `image` (CV_32FC3, of the same size), fading to 0 at
// kStrip_px from them: the membrane that Poisson blending spans over a strip, whose gradients stay
// those of the image (Perez, Gangnet and Blake, "Poisson image editing", 2003; along seams:
// Waechter, Moehrle and Goesele, "Let there be color!", 2014).
inline constexpr int kStrip_px = 10;
void add_membrane(const SeamResiduals& residuals, cv::Mat& image);

}  // namespace divemesh::texture
