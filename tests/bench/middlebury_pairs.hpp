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
    cv::Mat truth_px;  // CV_32F; 0: unknown or hidden in the right picture
};

// Returns Cones, Cloth3 and Adirondack of the shared Middlebury data.
std::vector<StereoPair> read_middlebury_pairs(const std::filesystem::path& middlebury);

// What makes a photograph harder to match.
struct ImageCondition {
    std::string name;
    double contrast = 1.0;
    double blur_px = 0.0;  // sigma
    double noise = 0.0;    // sigma, grey values
};

// As it is, at contrast 0.3, blurred by 1.5 px, with noise of 6.
const std::vector<ImageCondition>& image_conditions();

StereoPair changed(const StereoPair& pair, const ImageCondition& condition);

// How a matcher's disparities agree with the truth.
struct DisparityScore {
    double density = 0.0;           // answered, of the pixels with a truth
    double bad2_or_missing = 0.0;   // of the same
    double bad2_of_answered = 0.0;  // of the answered
};

// The first 128 columns are left out.
DisparityScore score(const cv::Mat& disparity_px, const cv::Mat& truth_px);

// Returns the share of bad-2.0 among the answered pixels with the smallest sigmas, `density` of the
// pixels with a truth; all answered ones if they are fewer.
double bad2_at_density(const cv::Mat& disparity_px,
                       const cv::Mat& sigma_px,
                       const cv::Mat& truth_px,
                       double density);

inline constexpr int kMiddleburyDisparities = 128;

}  // namespace divemesh::bench
