#include "tests/bench/klt_baseline.hpp"

#include <algorithm>
#include <ctime>
#include <opencv2/core/utility.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>
#include <vector>

#include "tests/bench/images.hpp"

namespace divemesh::bench {
namespace {

constexpr int kNumFeatures = 300;
constexpr double kQuality = 0.01;
constexpr double kMinDistance_px = 15.0;

double cpu_s() {
    timespec now{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

// From `before` to `now` and back.
void track_both_ways(const cv::Mat& before,
                     const cv::Mat& now,
                     const std::vector<cv::Point2f>& features) {
    if (features.empty()) return;
    std::vector<cv::Point2f> there;
    std::vector<cv::Point2f> back;
    std::vector<std::uint8_t> found;
    std::vector<float> error;
    cv::calcOpticalFlowPyrLK(before, now, features, there, found, error);
    cv::calcOpticalFlowPyrLK(now, before, there, back, found, error);
}

}  // namespace

double klt_cpu_ms_per_frame(const std::filesystem::path& dive) {
    const PairFiles pairs = pair_files(dive);
    cv::Mat before;
    std::vector<cv::Point2f> features;
    const double start_s = cpu_s();
    for (const auto& [left, right] : pairs) {
        const cv::Mat now = cv::imread(left.string(), cv::IMREAD_GRAYSCALE);
        cv::imread(right.string(), cv::IMREAD_GRAYSCALE);
        if (!before.empty()) track_both_ways(before, now, features);
        cv::goodFeaturesToTrack(now, features, kNumFeatures, kQuality, kMinDistance_px);
        before = now;
    }
    return 1e3 * (cpu_s() - start_s) / static_cast<double>(std::max<std::size_t>(1, pairs.size()));
}

}  // namespace divemesh::bench
