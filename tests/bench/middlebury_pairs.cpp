#include "tests/bench/middlebury_pairs.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <utility>

namespace divemesh::bench {
namespace {

namespace fs = std::filesystem;

constexpr double kBad_px = 2.0;

cv::Mat read_grey(const fs::path& file) { return cv::imread(file.string(), cv::IMREAD_GRAYSCALE); }

cv::Mat read_disparity(const fs::path& file, double scale) {
    cv::Mat disparity;
    read_grey(file).convertTo(disparity, CV_32F, 1.0 / scale);
    return disparity;
}

// Clears the pixels that the truth of the right image does not confirm: they are hidden there.
void leave_out_hidden(cv::Mat& left_px, const cv::Mat& right_px) {
    for (int y = 0; y < left_px.rows; ++y)
        for (int x = 0; x < left_px.cols; ++x) {
            float& d = left_px.at<float>(y, x);
            const int there = x - static_cast<int>(std::lround(d));
            if (there < 0 || std::abs(right_px.at<float>(y, there) - d) > 1.0F) d = 0.0F;
        }
}

}  // namespace

std::vector<StereoPair> read_middlebury_pairs(const fs::path& folder) {
    const auto both = [&](const char* name, const char* const(&files)[4], double scale) {
        const fs::path path = folder / name;
        StereoPair pair{name,
                        read_grey(path / files[0]),
                        read_grey(path / files[1]),
                        read_disparity(path / files[2], scale)};
        leave_out_hidden(pair.truth_px, read_disparity(path / files[3], scale));
        return pair;
    };
    std::vector<StereoPair> pairs = {
        both("Cones", {"im2.png", "im6.png", "disp2.png", "disp6.png"}, 4.0),
        both("Cloth3", {"view1.png", "view5.png", "disp1.png", "disp5.png"}, 2.0)};
    const fs::path path = folder / "Adirondack";
    pairs.push_back({"Adirondack",
                     read_grey(path / "left.png"),
                     read_grey(path / "right.png"),
                     read_disparity(path / "gt.png", 1.0)});
    pairs.back().truth_px.setTo(0.0, read_grey(path / "mask.png") < 255);
    return pairs;
}

const std::vector<ImageCondition>& image_conditions() {
    static const std::vector<ImageCondition> conditions = {{"as_is", 1.0, 0.0, 0.0},
                                                           {"contrast_0.3", 0.3, 0.0, 0.0},
                                                           {"blur_1.5_px", 1.0, 1.5, 0.0},
                                                           {"noise_6", 1.0, 0.0, 6.0}};
    return conditions;
}

StereoPair changed(const StereoPair& pair, const ImageCondition& condition) {
    StereoPair result = pair;
    cv::RNG random(7);
    for (cv::Mat* image : {&result.left, &result.right}) {
        cv::Mat grey;
        image->convertTo(grey, CV_32F);
        const double mean = cv::mean(grey)[0];
        grey = mean + condition.contrast * (grey - mean);
        if (condition.blur_px > 0.0) cv::GaussianBlur(grey, grey, {}, condition.blur_px);
        if (condition.noise > 0.0) {
            cv::Mat noise(grey.size(), CV_32F);
            random.fill(noise, cv::RNG::NORMAL, 0.0, condition.noise);
            grey += noise;
        }
        cv::Mat rounded;
        grey.convertTo(rounded, CV_8U);
        *image = rounded;
    }
    return result;
}

DisparityScore score(const cv::Mat& disparity_px, const cv::Mat& truth_px) {
    double num = 0.0;
    double num_answered = 0.0;
    double num_bad = 0.0;
    for (int y = 0; y < truth_px.rows; ++y)
        for (int x = kMiddleburyDisparities; x < truth_px.cols; ++x) {
            const float truth = truth_px.at<float>(y, x);
            if (truth <= 0.0F) continue;
            const float d = disparity_px.at<float>(y, x);
            num += 1.0;
            if (d <= 0.0F) continue;
            num_answered += 1.0;
            if (std::abs(d - truth) > kBad_px) num_bad += 1.0;
        }
    const double all = std::max(1.0, num);
    return {num_answered / all,
            (num - num_answered + num_bad) / all,
            num_bad / std::max(1.0, num_answered)};
}

double bad2_at_density(const cv::Mat& disparity_px,
                       const cv::Mat& sigma_px,
                       const cv::Mat& truth_px,
                       double density) {
    std::vector<std::pair<float, bool>> answered;  // sigma, whether it is bad
    double num = 0.0;
    for (int y = 0; y < truth_px.rows; ++y)
        for (int x = kMiddleburyDisparities; x < truth_px.cols; ++x) {
            const float truth = truth_px.at<float>(y, x);
            if (truth <= 0.0F) continue;
            num += 1.0;
            const float d = disparity_px.at<float>(y, x);
            if (d > 0.0F)
                answered.emplace_back(sigma_px.at<float>(y, x), std::abs(d - truth) > kBad_px);
        }
    std::sort(answered.begin(), answered.end());
    const auto kept = std::min(answered.size(), static_cast<std::size_t>(density * num));
    const auto num_bad = std::count_if(answered.begin(),
                                       answered.begin() + static_cast<std::ptrdiff_t>(kept),
                                       [](const auto& each) { return each.second; });
    return static_cast<double>(num_bad) / static_cast<double>(std::max<std::size_t>(1, kept));
}

}  // namespace divemesh::bench
