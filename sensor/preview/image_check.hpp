#pragma once

#include <cstdint>
#include <deque>
#include <opencv2/core/mat.hpp>
#include <optional>

namespace divemesh::sensor {

// What one picture is like.
struct ImageQuality {
    double mean_level = 0.0;    // 0 to 1, of all grey levels
    double black_share = 0.0;   // of its pixels
    double bright_share = 0.0;  // of its pixels: overexposed
    // How much of its strongest edges a blur takes, whatever their contrast: near 1 when they were
    // blurred before, 2 and more when they are sharp. Nothing where there are no edges.
    std::optional<double> sharpness;
    bool is_dark = false;
    bool is_blurred = false;
    bool is_frozen = false;  // nothing changed since the frame before
};

// Which of the last pictures are of no use.
class ImageCheck {
public:
    struct Shares {
        double dark = 0.0;
        double blurred = 0.0;
        double frozen = 0.0;
    };

    // `picture` CV_8UC1 or BGR. The same stamp again is not a new picture.
    ImageQuality look(const cv::Mat& image, std::int64_t timestamp_ns);
    std::optional<Shares> shares() const;  // of the last 20; nothing before the first
    void forget();                         // another dive

private:
    std::deque<ImageQuality> last_;
    cv::Mat before_;
    std::int64_t before_ns_ = -1;
};

// Of one picture alone, CV_8UC1.
ImageQuality measure_image(const cv::Mat& grey);

}  // namespace divemesh::sensor
