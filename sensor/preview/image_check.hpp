#pragma once

#include <cstdint>
#include <deque>
#include <opencv2/core/mat.hpp>
#include <optional>

namespace divemesh::sensor {

// The quality of one image.
struct ImageQuality {
    double mean_level = 0.0;    // of all grey levels, 0 to 1
    double black_share = 0.0;   // of the pixels
    double bright_share = 0.0;  // of the pixels: overexposed
    // How much a blur reduces the strongest edges, independent of their contrast: near 1 if they
    // were blurred before, 2 and more if they are sharp. nullopt without edges.
    std::optional<double> sharpness;
    bool is_dark = false;
    bool is_blurred = false;
    bool is_frozen = false;  // unchanged since the last frame
};

// Shares of the last images that are useless.
class ImageCheck {
public:
    struct Shares {
        double dark = 0.0;
        double blurred = 0.0;
        double frozen = 0.0;
    };

    // Measures an image, CV_8UC1 or BGR. The same stamp again does not count as a new image.
    ImageQuality check(const cv::Mat& image, std::int64_t timestamp_ns);
    std::optional<Shares> shares() const;  // of the last 20; nullopt before the first
    void forget();                         // call it for another dive

private:
    std::deque<ImageQuality> last_;
    cv::Mat before_;
    std::int64_t before_ns_ = -1;
};

// Returns the quality of a single image, CV_8UC1.
ImageQuality measure_image(const cv::Mat& grey);

}  // namespace divemesh::sensor
