#pragma once

#include <cstdint>
#include <opencv2/core/mat.hpp>

namespace divemesh::simulator {

struct SensorOptions {
    float exposure = 1.0F;
    bool noise = true;          // photons and read-out
    float full_well = 4000.0F;  // electrons at white
    float read_noise = 10.0F;   // electrons
    float vignetting = 0.28F;   // light lost in the corners
    std::uint64_t seed = 0;
};

// Turns linear light (CV_32FC3, r g b) into the picture a camera stores: vignetting, exposure that
// wanders by a few per cent, noise, tone curve; 8 bit BGR. `picture` numbers pictures of a dive.
cv::Mat develop(const cv::Mat& radiance,
                std::uint64_t image_number,
                double t_s,
                const SensorOptions& options);

// The tone curve: linear 0 to 1 to 0 to 255 with a gamma of 2.2.
std::uint8_t tone(float linear);
// Tone curve alone, no noise: for truth.
cv::Mat to_8_bit(const cv::Mat& linear);

}  // namespace divemesh::simulator
