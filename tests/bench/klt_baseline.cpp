#include "tests/bench/klt_baseline.hpp"

#include <algorithm>
#include <ctime>
#include <opencv2/core/utility.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>
#include <vector>

namespace divemesh::bench {
namespace {

namespace fs = std::filesystem;

constexpr int kNumFeatures = 300;
constexpr double kQuality = 0.01;
constexpr double kLeastDistance_px = 15.0;

std::vector<fs::path> pictures_in(const fs::path& folder) {
    std::vector<fs::path> files;
    for (const auto& entry : fs::directory_iterator(folder)) files.push_back(entry.path());
    std::sort(files.begin(), files.end());
    return files;
}

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

double klt_cpu_ms_per_frame(const fs::path& dive) {
    const fs::path mav0 = fs::exists(dive / "mav0") ? dive / "mav0" : dive;
    const auto left = pictures_in(mav0 / "cam0" / "data");
    const auto right = pictures_in(mav0 / "cam1" / "data");
    const std::size_t num_frames = std::min(left.size(), right.size());
    cv::Mat before;
    std::vector<cv::Point2f> features;
    const double start_s = cpu_s();
    for (std::size_t i = 0; i < num_frames; ++i) {
        const cv::Mat now = cv::imread(left[i].string(), cv::IMREAD_GRAYSCALE);
        cv::imread(right[i].string(), cv::IMREAD_GRAYSCALE);
        if (!before.empty()) track_both_ways(before, now, features);
        cv::goodFeaturesToTrack(now, features, kNumFeatures, kQuality, kLeastDistance_px);
        before = now;
    }
    return 1e3 * (cpu_s() - start_s) / static_cast<double>(std::max<std::size_t>(1, num_frames));
}

}  // namespace divemesh::bench
