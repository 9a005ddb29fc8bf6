#include "worker/dive/repeated_images.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <functional>
#include <opencv2/imgproc.hpp>
#include <utility>
#include <vector>

namespace divemesh::dive {
namespace {

constexpr double kMinDeviation = 2.0;  // grey values; less is water, or a lens cap
constexpr int kReduction = 8;          // averages noise and what coding changes
constexpr int kMinSize_px = 64;
// Grey values (RMS) of reduced images. A copy that a video codec skips changes by 0, one in JPEG of
// quality 95 by 0.02 to 0.15; the noise of a camera at rest changes them by 0.2 to 0.6, motion by 4
// to 70.
constexpr double kMaxReencoded = 0.15;
constexpr double kMaxOfMotion = 0.08;  // of what changes while the scene moves
constexpr double kMinMotion = 1.5;
constexpr std::size_t kNumDifferences = 9;
constexpr std::size_t kMinDifferences = 3;
constexpr int kMaxInRow = 3;  // a camera of 10 images a second in a video of 40; more is a rest

bool is_same(const cv::Mat& before, const cv::Mat& image) {
    for (int row = 0; row < image.rows; ++row)
        if (std::memcmp(before.ptr(row),
                        image.ptr(row),
                        static_cast<std::size_t>(image.cols) * image.elemSize()) != 0)
            return false;
    return true;
}

bool shows_scene(const cv::Mat& image) {
    cv::Scalar mean;
    cv::Scalar deviation;
    cv::meanStdDev(image, mean, deviation);
    return deviation[0] > kMinDeviation;
}

// Returns the middle quarter of the rows, reduced, without its mean (CV_32F). It is converted
// first, as means of whole grey values would be rounded by more than coding changes them.
cv::Mat reduced_middle(const cv::Mat& image) {
    constexpr double kScale = 1.0 / kReduction;
    cv::Mat values;
    image.rowRange(image.rows * 3 / 8, image.rows * 5 / 8).convertTo(values, CV_32F);
    cv::Mat small;
    cv::resize(values, small, {}, kScale, kScale, cv::INTER_AREA);
    return small - cv::mean(small);
}

// Returns the RMS difference, grey values.
double difference_of(const cv::Mat& before, const cv::Mat& small) {
    return cv::norm(small, before) / std::sqrt(static_cast<double>(small.total()));
}

}  // namespace

RepeatedImages::Kind RepeatedImages::add(const cv::Mat& image) {
    const cv::Mat before = std::exchange(previous_, image);
    const bool is_first = before.empty();
    const bool is_new_size = before.size() != image.size();
    if (!is_new_size && is_same(before, image) && shows_scene(image)) return Kind::Exact;
    if (image.cols < kMinSize_px || image.rows < kMinSize_px) return Kind::No;
    const cv::Mat small = reduced_middle(image);
    if (!is_new_size) return is_reencoded(small) ? Kind::Reencoded : Kind::No;
    previous_small_ = small;
    if (!is_first) differences_.clear();
    num_reencoded_ = 0;
    return Kind::No;
}

void RepeatedImages::learn(const std::vector<cv::Mat>& first) {
    cv::Mat before;
    for (const cv::Mat& image : first) {
        if (image.cols < kMinSize_px || image.rows < kMinSize_px) continue;
        const cv::Mat small = reduced_middle(image);
        if (before.size() == small.size()) keep(difference_of(before, small));
        before = small;
    }
}

void RepeatedImages::keep(double difference) {
    differences_.push_back(difference);
    if (differences_.size() > kNumDifferences) differences_.pop_front();
}

// The first repetitions of a recording count among the differences.
double RepeatedImages::usual_motion() const {
    if (differences_.size() < kMinDifferences) return 0.0;
    std::vector<double> sorted(differences_.begin(), differences_.end());
    std::ranges::nth_element(sorted, sorted.begin() + 1, std::greater());
    return sorted[1];
}

bool RepeatedImages::is_reencoded(const cv::Mat& small) {
    const double difference = difference_of(previous_small_, small);
    const double motion = usual_motion();
    const bool stays = difference < std::min(kMaxReencoded, kMaxOfMotion * motion);
    if (!stays) num_reencoded_ = 0;
    if (stays && motion > kMinMotion && num_reencoded_ < kMaxInRow) {
        ++num_reencoded_;
        return true;
    }
    previous_small_ = small;
    keep(difference);
    return false;
}

}  // namespace divemesh::dive
