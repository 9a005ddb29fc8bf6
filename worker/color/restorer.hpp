#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "worker/color/color_fit.hpp"
#include "worker/color/linear_light.hpp"
#include "worker/color/white_point.hpp"

namespace divemesh::color {

// A colour without water.
struct RestoredColor {
    Rgb rgb = {};                // linear light, 1 is white; may exceed it
    float amplification = 0.0F;  // of the noise of the image, mean over the channels
    // Less was restored than the water took: it would have been noise, or the surface is farther
    // than those of the fit.
    bool is_limited = false;
};

// Takes the water off colours: the inverse of ColorFit, with gains and vignetting. It amplifies a
// channel at most until the noise of dark pixels becomes kMaxNoise of white, and takes ranges
// beyond those of the fit for the nearest of them.
class Restorer {
public:
    static constexpr double kMaxNoise = 0.1;  // grain that is seen, but does not hide the surface

    // Throws std::logic_error if the water is not known.
    Restorer(const ColorFit& fit, const WhitePoint& white);

    // Linear light to be restored, as keyframe `keyframe` shows it of a surface, with range,
    // eccentricity and cosine as in Sighting.
    struct Seen {
        Rgb rgb = {};
        float range_m = 0.0F;
        float eccentricity = 0.0F;
        float cosine = 1.0F;
    };
    RestoredColor restore(const Seen& seen, std::size_t keyframe) const;

private:
    // At steps of the range: interpolating is much faster than exponentials.
    struct Step {
        Rgb added;  // by backscatter
        Rgb sky;    // shares of DirectShare, times white
        Rgb lamps;
    };
    Step step_at(float range_m) const;

    std::vector<Step> steps_;
    float near_m_ = 0.0F;
    float far_m_ = 0.0F;
    float steps_per_m_ = 0.0F;
    float vignetting_ = 0.0F;
    std::vector<float> inverse_gains_;
    Rgb largest_ = {};  // factor of each channel, from an image to white
};

}  // namespace divemesh::color
