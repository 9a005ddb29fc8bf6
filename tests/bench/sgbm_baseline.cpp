#include "tests/bench/sgbm_baseline.hpp"

#include <chrono>
#include <opencv2/calib3d.hpp>
#include <opencv2/core/utility.hpp>
#include <opencv2/imgcodecs.hpp>

#include "tests/bench/images.hpp"

namespace divemesh::bench {

double sgbm_ms_per_frame(const std::filesystem::path& dive, int stride) {
    cv::setNumThreads(1);
    const auto matcher =
        cv::StereoSGBM::create(0, 128, 5, 200, 800, 0, 0, 0, 0, 0, cv::StereoSGBM::MODE_SGBM_3WAY);
    const PairFiles pairs = pair_files(dive);
    cv::Mat disparity;
    double sum_ms = 0.0;
    int num_pairs = 0;
    for (std::size_t i = 0; i < pairs.size(); i += static_cast<std::size_t>(stride)) {
        const cv::Mat left = cv::imread(pairs[i].first.string(), cv::IMREAD_GRAYSCALE);
        const cv::Mat right = cv::imread(pairs[i].second.string(), cv::IMREAD_GRAYSCALE);
        const auto start = std::chrono::steady_clock::now();
        matcher->compute(left, right, disparity);
        const std::chrono::duration<double, std::milli> taken =
            std::chrono::steady_clock::now() - start;
        sum_ms += taken.count();
        ++num_pairs;
    }
    return num_pairs > 0 ? sum_ms / num_pairs : 0.0;
}

}  // namespace divemesh::bench
