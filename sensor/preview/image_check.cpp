#include "sensor/preview/image_check.hpp"

#include <algorithm>
#include <array>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "worker/stats/quantile.hpp"

namespace divemesh::sensor {
namespace {

constexpr std::size_t kMaxImages = 20;
constexpr int kWorkWidth_px = 640;  // wider images are measured at half or a quarter of their size
constexpr int kDarkLevel = 40;      // of 255; dark: less than a tenth of the image is brighter
constexpr double kSharp = 1.7;      // below: blurred by more than about 1.5 px
constexpr double kReblur_px = 2.0;
constexpr double kEdgeShare = 0.02;    // share of pixels that are the strongest edges
constexpr float kMinEdge = 2.0F;       // grey levels per px; weaker edges cannot be measured
constexpr double kFrozenLevels = 0.1;  // mean difference; the noise of a live camera is larger

double share_of(const cv::Mat& mask) {
    return static_cast<double>(cv::countNonZero(mask)) / static_cast<double>(mask.total());
}

int percentile(const cv::Mat& grey, double share) {
    std::array<std::int64_t, 256> histogram{};
    for (int v = 0; v < grey.rows; ++v)
        for (const std::uint8_t level : cv::Mat_<std::uint8_t>(grey.row(v))) ++histogram[level];
    auto left = static_cast<std::int64_t>(share * static_cast<double>(grey.total()));
    for (int level = 0; level < 256; ++level)
        if ((left -= histogram[static_cast<std::size_t>(level)]) < 0) return level;
    return 255;
}

cv::Mat gradient_of(const cv::Mat& grey) {
    cv::Mat dx, dy, magnitude;
    cv::Sobel(grey, dx, CV_32F, 1, 0, 3, 1.0 / 8.0);
    cv::Sobel(grey, dy, CV_32F, 0, 1, 3, 1.0 / 8.0);
    cv::magnitude(dx, dy, magnitude);
    return magnitude;
}

// Crete et al., "The blur effect" (2007), at the strongest edges only: noise and marine snow
// between them tell nothing about focus.
std::optional<double> sharpness_of(const cv::Mat& grey) {
    cv::Mat blurred;
    cv::GaussianBlur(grey, blurred, {}, kReblur_px);
    const cv::Mat fine = gradient_of(grey);
    const cv::Mat coarse = gradient_of(blurred);
    const float strong = stats::upper_quantile(
        std::vector<float>(coarse.begin<float>(), coarse.end<float>()), 1.0 - kEdgeShare);
    if (strong < kMinEdge) return std::nullopt;
    const cv::Mat edges = coarse >= strong;
    // On the edge itself, not beside it: the blur spreads it to both sides.
    cv::Mat peaks;
    cv::dilate(fine, peaks, cv::Mat::ones(5, 5, CV_8U));
    return cv::mean(peaks, edges)[0] / cv::mean(coarse, edges)[0];
}

cv::Mat grey_of(const cv::Mat& image) {
    if (image.channels() == 1) return image;
    cv::Mat grey;
    cv::cvtColor(image, grey, cv::COLOR_BGR2GRAY);
    return grey;
}

}  // namespace

ImageQuality measure_image(const cv::Mat& grey) {
    ImageQuality quality;
    quality.mean_level = cv::mean(grey)[0] / 255.0;
    quality.black_share = share_of(grey <= 2);
    quality.bright_share = share_of(grey >= 253);
    quality.is_dark = percentile(grey, 0.9) < kDarkLevel;
    cv::Mat small = grey;
    while (small.cols > 2 * kWorkWidth_px) cv::pyrDown(cv::Mat(small), small);
    if (small.cols >= 16 && small.rows >= 16) quality.sharpness = sharpness_of(small);
    quality.is_blurred = quality.sharpness && *quality.sharpness < kSharp;
    return quality;
}

ImageQuality ImageCheck::check(const cv::Mat& image, std::int64_t timestamp_ns) {
    const cv::Mat grey = grey_of(image);
    ImageQuality quality = measure_image(grey);
    if (timestamp_ns == before_ns_) return quality;
    if (before_.size() == grey.size())
        quality.is_frozen = cv::norm(before_, grey, cv::NORM_L1) <
                            kFrozenLevels * static_cast<double>(grey.total());
    before_ = grey.clone();
    before_ns_ = timestamp_ns;
    last_.push_back(quality);
    if (last_.size() > kMaxImages) last_.pop_front();
    return quality;
}

std::optional<ImageCheck::Shares> ImageCheck::shares() const {
    if (last_.empty()) return std::nullopt;
    const auto share = [&](bool ImageQuality::*is_so) {
        const auto count =
            std::count_if(last_.begin(), last_.end(), [&](const auto& one) { return one.*is_so; });
        return static_cast<double>(count) / static_cast<double>(last_.size());
    };
    return Shares{share(&ImageQuality::is_dark),
                  share(&ImageQuality::is_blurred),
                  share(&ImageQuality::is_frozen)};
}

void ImageCheck::forget() {
    last_.clear();
    before_.release();
    before_ns_ = -1;
}

}  // namespace divemesh::sensor
