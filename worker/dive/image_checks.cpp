#include "worker/dive/image_checks.hpp"

#include <algorithm>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

#include "worker/base/text.hpp"
#include "worker/dive/fixed_pattern.hpp"
#include "worker/dive/image_measures.hpp"
#include "worker/stats/median.hpp"

namespace divemesh::dive {
namespace {

constexpr int kNumChecked = 16;
constexpr int kNumPrefetched = 3;  // pairs
constexpr std::size_t kMinChecked = 3;
// Thresholds, with what healthy and spoilt recordings have, real ones among them.
constexpr double kMinSharpness = 0.75;  // right over left; healthy 0.91 to 1.05, spoilt 0.3 to 0.42
constexpr double kMaxCombing = 1.2;     // healthy 0.85 to 1.05, interlaced 1.4 to 5.5
constexpr double kMaxMosaic = 0.01;     // healthy below 0.001, Bayer 0.24
constexpr double kHasNoMatch = 0.05;    // share of corners; cameras that match have 0.25 and more
constexpr double kMinShareWithoutTexture = 0.05;
constexpr double kAllWithoutTexture = 0.95;

// What was measured on the checked frames.
struct Measured {
    std::vector<double> sharpness_ratio;  // right over left
    std::vector<double> combing;
    std::vector<double> mosaic;
    std::vector<int> without_texture;  // frames
    int num_frames = 0;
    FixedPattern pattern;
};

cv::Mat halved(const cv::Mat& image) {
    cv::Mat half;
    cv::resize(image, half, {}, 0.5, 0.5, cv::INTER_AREA);
    return half;
}

Measured measure(int num_frames, const std::function<LoadedPair(int index)>& load) {
    Measured measured;
    const int num_checked = std::min(kNumChecked, num_frames);
    FrameReader reader(num_checked, kNumPrefetched, [&](int k) {
        return load((2 * k + 1) * num_frames / (2 * num_checked));
    });
    while (const auto pair = reader.next()) {
        if (!pair->is_complete()) continue;
        const cv::Mat& left = pair->left.image;
        ++measured.num_frames;
        measured.pattern.add(left);
        measured.combing.push_back(combing(left));
        measured.mosaic.push_back(mosaic_contrast(left));
        // The pattern of a mosaic would pass for noise and for sharp detail.
        const bool is_mosaic = measured.mosaic.back() > kMaxMosaic;
        const cv::Mat scene = reduced_to_640_px(is_mosaic ? halved(left) : left);
        if (!has_texture(scene)) {
            measured.without_texture.push_back(pair->index);
            continue;
        }
        const double reference = sharpness(scene);
        const cv::Mat right = reduced_to_640_px(pair->right.image);
        const double other = sharpness(is_mosaic ? halved(pair->right.image) : right);
        // An image of one tone is blank, not out of focus.
        if (reference > 0.0 && other > 0.0 && !is_dark(right))
            measured.sharpness_ratio.push_back(other / reference);
    }
    return measured;
}

void report_sharpness(const Measured& measured,
                      std::optional<double> share_matching,
                      FindingLog& findings) {
    if (measured.sharpness_ratio.size() < kMinChecked) return;
    const double ratio = stats::median(measured.sharpness_ratio);
    const bool right_is_worse = ratio < kMinSharpness;
    if (!right_is_worse && ratio < 1.0 / kMinSharpness) return;
    const double times = right_is_worse ? 1.0 / ratio : ratio;
    const std::string worse = right_is_worse ? "cam1" : "cam0";
    const bool matches = !share_matching || *share_matching >= kHasNoMatch;
    findings.add({matches ? Severity::Warning : Severity::Error,
                  "camera_unsharp",
                  "mav0/" + worse + "/data",
                  "images of " + worse + " have " + base::fixed(times, 1) +
                      " times less fine detail than those of the other camera: it is out of "
                      "focus, or its port is fogged or dirty" +
                      (matches ? "" : ", and nothing in one image is found in the other"),
                  "Focus both cameras under water, dry the housing and clean the port; then "
                  "calibrate again."});
}

void report_combing(const Measured& measured, FindingLog& findings) {
    if (measured.combing.size() < kMinChecked) return;
    const double value = stats::median(measured.combing);
    if (value < kMaxCombing) return;
    findings.warning("images_interlaced",
                     "mav0/cam0/data",
                     "every second line shows another moment (neighbouring lines differ " +
                         base::fixed(value, 1) +
                         " times as much as neighbouring columns): the video is interlaced",
                     "Record progressive video, or take one field of each frame (ffmpeg -vf "
                     "bwdif) before the calibration and the dive.");
}

void report_mosaic(const Measured& measured, FindingLog& findings) {
    if (measured.mosaic.size() < kMinChecked) return;
    const double value = stats::median(measured.mosaic);
    if (value < kMaxMosaic) return;
    findings.warning("images_bayer",
                     "mav0/cam0/data",
                     "neighbouring pixels differ by " + base::fixed(100.0 * value, 0) +
                         " % in a fixed 2 x 2 pattern: grey images hold a Bayer mosaic, which "
                         "looks like texture and has lost its colours",
                     "Convert raw images to colour (OpenCV: cvtColor with COLOR_Bayer...2BGR) and "
                     "put those into the dive.");
}

void report_texture(const Measured& measured,
                    std::optional<double> share_matching,
                    FindingLog& findings) {
    if (measured.num_frames == 0 || measured.without_texture.empty()) return;
    const double share = static_cast<double>(measured.without_texture.size()) / measured.num_frames;
    if (share < kMinShareWithoutTexture) return;
    const bool is_all = share > kAllWithoutTexture;
    const std::string where = "between frames " + std::to_string(measured.without_texture.front()) +
                              " and " + std::to_string(measured.without_texture.back());
    // Images that all lack texture and have too few corners to test show nothing either.
    const bool has_match = share_matching.value_or(0.0) >= kHasNoMatch;
    findings.add({is_all && !has_match ? Severity::Error : Severity::Warning,
                  "images_featureless",
                  "mav0/cam0/data",
                  base::fixed(100.0 * share, 0) + " % of the frames show no trackable features" +
                      (is_all ? "" : ", " + where) +
                      ": open water, sand without detail, or too little light or contrast",
                  "Keep the bottom or the wall in view, nearer to it or with more light."});
}

}  // namespace

cv::Mat check_images(int num_frames,
                     const std::function<LoadedPair(int index)>& load,
                     std::optional<double> share_matching,
                     FindingLog& findings) {
    const Measured measured = measure(num_frames, load);
    report_sharpness(measured, share_matching, findings);
    report_combing(measured, findings);
    report_mosaic(measured, findings);
    report_texture(measured, share_matching, findings);
    const FixedPattern::Masks fixed = measured.pattern.masks();
    if (!fixed.overlay.empty())
        findings.warning(
            "images_fixed_pattern",
            "mav0/cam0/data",
            "a pattern around " +
                base::fixed(100.0 * cv::countNonZero(fixed.overlay) /
                                static_cast<double>(fixed.overlay.total()),
                            0) +
                " % of the image stays in place while the scene moves: text that the camera burns "
                "in, or a part of the rig. Neither features nor surface are taken from there",
            "Switch the display of time and depth off for recordings, and keep the rig out of "
            "view.");
    return fixed.all();
}

}  // namespace divemesh::dive
