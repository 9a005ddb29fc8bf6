#pragma once

#include <cstdint>
#include <opencv2/core/mat.hpp>

namespace divemesh::simulator {

// Properties of a simulated image sensor.
struct SensorOptions {
    float exposure = 1.0F;
    bool noise = true;          // shot noise and read noise
    float full_well = 4000.0F;  // electrons at white
    float read_noise = 10.0F;   // electrons
    float vignetting = 0.28F;   // share of light lost in the corners
    std::uint64_t seed = 0;
};

// Returns the image that a camera stores from linear light (CV_32FC3, r g b): vignetting, an
// exposure that varies by a few per cent, noise and tone curve; 8 bit BGR. `image_number` is the
// number of the image in the dive.
cv::Mat develop(const cv::Mat& radiance,
                std::uint64_t image_number,
                double t_s,
                const SensorOptions& options);

// Returns the tone curve with a gamma of 2.2: linear 0 to 1 becomes 0 to 255.
std::uint8_t tone(float linear);
// Applies only the tone curve, without noise; for ground truth.
cv::Mat to_8_bit(const cv::Mat& linear);

}  // namespace divemesh::simulator
