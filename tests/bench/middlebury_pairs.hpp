#pragma once

#include <filesystem>
#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

namespace divemesh::bench {

// A rectified pair of photographs with measured disparities.
struct StereoPair {
    std::string name;
    cv::Mat left;
    cv::Mat right;
    cv::Mat truth_px;  // CV_32F; 0: unknown or hidden in the right image
};

// Returns Cones, Cloth3 and Adirondack of the shared Middlebury data.
std::vector<StereoPair> read_middlebury_pairs(const std::filesystem::path& middlebury);

// A degradation that makes images harder to match.
struct ImageCondition {
    std::string name;
    double contrast = 1.0;
    double blur_px = 0.0;  // sigma
    double noise = 0.0;    // sigma, grey values
};

// Returns four conditions: unchanged, contrast 0.3, blur of 1.5 px, noise of 6 grey values.
const std::vector<ImageCondition>& image_conditions();

// Returns the pair with both images degraded.
StereoPair changed(const StereoPair& pair, const ImageCondition& condition);

// The agreement of a matcher's disparities with the truth. "Answered" pixels have a disparity.
struct DisparityScore {
    double density = 0.0;           // answered pixels, share of the pixels with a truth
    double bad2_or_missing = 0.0;   // off by more than 2 px or not answered, share of the same
    double bad2_of_answered = 0.0;  // off by more than 2 px, share of the answered pixels
};

// Returns the score, without the first 128 columns.
DisparityScore score(const cv::Mat& disparity_px, const cv::Mat& truth_px);

// Returns the share of disparities off by more than 2 px among the answered pixels with the
// smallest sigmas. Takes as many of them as `density` times the pixels with a truth, or all if
// there are fewer.
double bad2_at_density(const cv::Mat& disparity_px,
                       const cv::Mat& sigma_px,
                       const cv::Mat& truth_px,
                       double density);

inline constexpr int kMiddleburyDisparities = 128;

}  // namespace divemesh::bench
