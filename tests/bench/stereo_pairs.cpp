#include "tests/bench/stereo_pairs.hpp"

#include <algorithm>
#include <map>
#include <opencv2/calib3d.hpp>
#include <string>
#include <vector>

#include "schemas/reconstruction_options.hpp"
#include "tests/bench/middlebury_pairs.hpp"
#include "worker/stereo/match_stereo.hpp"

namespace divemesh::bench {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

types::DepthMap match_own(const StereoPair& pair) {
    types::RectifiedFrame frame;
    frame.left = pair.left;
    frame.right = pair.right;
    return stereo::StereoMatcher(
               "sgm", kMiddleburyDisparities, ReconstructionOptions().stereo_scales)
        .match(frame);
}

struct OpenCvVariant {
    int mode;
    int block;
    int uniqueness_percent;  // -1: no checks
};

cv::Mat match_opencv(const StereoPair& pair, const OpenCvVariant& variant) {
    const int area = variant.block * variant.block;  // penalties as OpenCV's manual advises
    const bool checked = variant.uniqueness_percent >= 0;
    const auto matcher = cv::StereoSGBM::create(0,
                                                kMiddleburyDisparities,
                                                variant.block,
                                                8 * area,
                                                32 * area,
                                                checked ? 1 : -1,
                                                31,
                                                checked ? variant.uniqueness_percent : 0,
                                                0,
                                                0,
                                                variant.mode);
    cv::Mat fixed_point;
    cv::Mat disparity;
    matcher->compute(pair.left, pair.right, fixed_point);
    fixed_point.convertTo(disparity, CV_32F, 1.0 / 16.0);
    return disparity;
}

const std::map<std::string, int>& opencv_modes() {
    static const std::map<std::string, int> modes = {
        {"opencv_3way", cv::StereoSGBM::MODE_SGBM_3WAY},
        {"opencv_hh4", cv::StereoSGBM::MODE_HH4},
        {"opencv_sgbm", cv::StereoSGBM::MODE_SGBM}};
    return modes;
}

// Returns the least bad2_or_missing of all modes, checked and unchecked.
double best_of_opencv(const StereoPair& pair) {
    double best = 1.0;
    for (const auto& [name, mode] : opencv_modes())
        for (const int uniqueness_percent : {-1, 5})
            for (const int block : {3, 5})
                best = std::min(
                    best,
                    score(match_opencv(pair, {mode, block, uniqueness_percent}), pair.truth_px)
                        .bad2_or_missing);
    return best;
}

// Returns bad-2.0 of the answered, ours and the rival's, at the density of the rival. Where ours is
// less dense, the rival's uniqueness is raised until it is no denser.
void compare_at_equal_density(const StereoPair& pair, const types::DepthMap& own, json& result) {
    const double density = score(own.disparity_px, pair.truth_px).density;
    DisparityScore rival;
    for (int uniqueness_percent = 10; uniqueness_percent <= 60; uniqueness_percent += 5) {
        rival = score(match_opencv(pair, {cv::StereoSGBM::MODE_SGBM, 5, uniqueness_percent}),
                      pair.truth_px);
        if (rival.density <= density) break;
    }
    result["density_sgbm"] = rival.density;
    result["bad2_sgbm"] = rival.bad2_of_answered;
    result["bad2_at_density"] =
        bad2_at_density(own.disparity_px, own.sigma_disparity_px, pair.truth_px, rival.density);
}

}  // namespace

json compare_on_stereo_pairs(const fs::path& middlebury) {
    if (!fs::exists(middlebury)) return nullptr;
    const auto pairs = read_middlebury_pairs(middlebury);
    const auto mean_over_pairs = [&](const auto& match, json* each) {
        double sum = 0.0;
        for (const StereoPair& pair : pairs) {
            const double share = score(match(pair), pair.truth_px).bad2_or_missing;
            if (each) (*each)[pair.name] = share;
            sum += share;
        }
        return sum / static_cast<double>(pairs.size());
    };
    json result = {
        {"group", "surface"}, {"dive", "middlebury"}, {"preset", "standard"}, {"ablation", "none"}};
    const double own = mean_over_pairs(
        [](const StereoPair& pair) { return match_own(pair).disparity_px; }, &result["pairs"]);
    double best = 1.0;
    for (const auto& [name, mode] : opencv_modes())
        for (const bool checked : {true, false})
            for (const int block : {3, 5}) {
                const OpenCvVariant variant{mode, block, checked ? 5 : -1};
                const double share = mean_over_pairs(
                    [&](const StereoPair& pair) { return match_opencv(pair, variant); }, nullptr);
                auto& min_share = result[name][checked ? "checked" : "unchecked"];
                min_share = min_share.is_null() ? share : std::min(share, min_share.get<double>());
                best = std::min(best, share);
            }
    result["metrics"] = {
        {"bad2_or_missing", own}, {"bad2_or_missing_opencv", best}, {"bad2_to_opencv", own / best}};
    return result;
}

json compare_under_conditions(const fs::path& middlebury) {
    if (!fs::exists(middlebury)) return nullptr;
    json result = json::array();
    for (const StereoPair& original : read_middlebury_pairs(middlebury))
        for (const ImageCondition& condition : image_conditions()) {
            const StereoPair pair = changed(original, condition);
            const types::DepthMap own = match_own(pair);
            const DisparityScore of_own = score(own.disparity_px, pair.truth_px);
            json each = {{"pair", pair.name},
                         {"condition", condition.name},
                         {"density", of_own.density},
                         {"bad2_or_missing", of_own.bad2_or_missing},
                         {"bad2_or_missing_opencv", best_of_opencv(pair)},
                         {"bad2_of_answered", of_own.bad2_of_answered}};
            compare_at_equal_density(pair, own, each);
            result.push_back(std::move(each));
        }
    return result;
}

}  // namespace divemesh::bench
