#include "tests/bench/stereo_pairs.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>

#include "worker/stereo/match_stereo.hpp"

namespace divemesh::bench {
namespace {

namespace fs = std::filesystem;

constexpr int kNumDisparities = 128;
constexpr double kBad_px = 2.0;

struct StereoPair {
    std::string name;
    cv::Mat left;
    cv::Mat right;
    cv::Mat truth_px;  // CV_32F; 0: unknown or hidden in the right picture
};

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

std::vector<StereoPair> read_pairs(const fs::path& folder) {
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

double share_bad(const cv::Mat& disparity_px, const cv::Mat& truth_px) {
    std::int64_t num_bad = 0;
    std::int64_t num = 0;
    for (int y = 0; y < truth_px.rows; ++y)
        for (int x = kNumDisparities; x < truth_px.cols; ++x) {
            const float truth = truth_px.at<float>(y, x);
            if (truth <= 0.0F) continue;
            const float d = disparity_px.at<float>(y, x);
            ++num;
            if (d <= 0.0F || std::abs(d - truth) > kBad_px) ++num_bad;
        }
    return static_cast<double>(num_bad) / static_cast<double>(std::max<std::int64_t>(1, num));
}

cv::Mat match_own(const StereoPair& pair) {
    types::RectifiedFrame frame;
    frame.left = pair.left;
    frame.right = pair.right;
    return stereo::StereoMatcher("sgm", kNumDisparities).match(frame).disparity_px;
}

struct OpenCvVariant {
    int mode;
    int block;
    bool checked;
};

cv::Mat match_opencv(const StereoPair& pair, const OpenCvVariant& variant) {
    const int area = variant.block * variant.block;  // penalties as OpenCV's manual advises
    const auto matcher = cv::StereoSGBM::create(0,
                                                kNumDisparities,
                                                variant.block,
                                                8 * area,
                                                32 * area,
                                                variant.checked ? 1 : -1,
                                                31,
                                                variant.checked ? 5 : 0,
                                                0,
                                                0,
                                                variant.mode);
    cv::Mat fixed_point;
    cv::Mat disparity;
    matcher->compute(pair.left, pair.right, fixed_point);
    fixed_point.convertTo(disparity, CV_32F, 1.0 / 16.0);
    return disparity;
}

}  // namespace

nlohmann::json compare_on_stereo_pairs(const fs::path& middlebury) {
    if (!fs::exists(middlebury)) return nullptr;
    static const std::map<std::string, int> kModes = {
        {"opencv_3way", cv::StereoSGBM::MODE_SGBM_3WAY},
        {"opencv_hh4", cv::StereoSGBM::MODE_HH4},
        {"opencv_sgbm", cv::StereoSGBM::MODE_SGBM}};
    const auto pairs = read_pairs(middlebury);
    const auto mean_over_pairs = [&](const auto& match, nlohmann::json* each) {
        double sum = 0.0;
        for (const StereoPair& pair : pairs) {
            const double share = share_bad(match(pair), pair.truth_px);
            if (each) (*each)[pair.name] = share;
            sum += share;
        }
        return sum / static_cast<double>(pairs.size());
    };
    nlohmann::json result = {
        {"group", "surface"}, {"dive", "middlebury"}, {"preset", "standard"}, {"ablation", "none"}};
    const double own = mean_over_pairs(match_own, &result["pairs"]);
    double best = 1.0;
    for (const auto& [name, mode] : kModes)
        for (const bool checked : {true, false})
            for (const int block : {3, 5}) {
                const OpenCvVariant variant{mode, block, checked};
                const double share = mean_over_pairs(
                    [&](const StereoPair& pair) { return match_opencv(pair, variant); }, nullptr);
                auto& min_share = result[name][checked ? "checked" : "unchecked"];
                min_share = min_share.is_null() ? share : std::min(share, min_share.get<double>());
                best = std::min(best, share);
            }
    result["figures"] = {
        {"bad2_or_missing", own}, {"bad2_or_missing_opencv", best}, {"bad2_to_opencv", own / best}};
    return result;
}

}  // namespace divemesh::bench
