#include "worker/dive/fixed_pattern.hpp"

#include <opencv2/imgproc.hpp>

namespace divemesh::dive {
namespace {

constexpr int kMinImages = 6;
constexpr double kStill = 4.0;           // grey values; standard deviation over time
constexpr double kEdge = 8.0;            // grey values per px
constexpr double kMinEdgeShare = 0.003;  // of the image; moving scenes have up to 0.0009
constexpr double kMaxStillShare = 0.5;   // of what is not black; the rig stands still
constexpr int kReach_px = 25;            // letters that change stand this near to fixed edges
constexpr double kMaxBlack = 16.0;       // grey value of the surroundings of a round image
constexpr int kMinSurroundings_px = 15;  // width; narrower ones are shadows and letters
constexpr double kMinSharpShare = 0.5;   // of the contour; light that fades has no edge
constexpr double kMinSceneShare = 0.02;  // of the image
constexpr int kBlur_px = 4;              // of the border by the lens
constexpr int kRim_px = 8;               // half a patch, and the blur

cv::Mat rectangle(int width_px, int height_px) {
    return cv::getStructuringElement(cv::MORPH_RECT, {width_px, height_px});
}

cv::Mat dilated(const cv::Mat& mask, int reach_px) {
    cv::Mat result;
    cv::dilate(mask, result, rectangle(2 * reach_px + 1, 2 * reach_px + 1));
    return result;
}

// Returns a mask of areas, larger than shadows, that are black in all images.
cv::Mat black_surroundings(const cv::Mat& mean, const cv::Mat& is_still) {
    const cv::Mat is_black = is_still & (mean < kMaxBlack);
    cv::Mat surroundings;
    cv::morphologyEx(is_black,
                     surroundings,
                     cv::MORPH_OPEN,
                     rectangle(kMinSurroundings_px, kMinSurroundings_px));
    return surroundings;
}

cv::Mat slope_of(const cv::Mat& mean) {
    cv::Mat x;
    cv::Mat y;
    cv::Sobel(mean, x, CV_32F, 1, 0, 3, 0.125);
    cv::Sobel(mean, y, CV_32F, 0, 1, 3, 0.125);
    cv::Mat slope;
    cv::magnitude(x, y, slope);
    return slope;
}

}  // namespace

void FixedPattern::add(const cv::Mat& image) {
    cv::Mat values;
    image.convertTo(values, CV_32F);
    if (num_images_++ == 0) {
        sum_ = cv::Mat::zeros(image.size(), CV_32F);
        sum_of_squares_ = cv::Mat::zeros(image.size(), CV_32F);
    }
    sum_ += values;
    sum_of_squares_ += values.mul(values);
}

cv::Mat FixedPattern::Masks::all() const {
    if (overlay.empty() || border.empty()) return overlay.empty() ? border : overlay;
    return overlay | border;
}

FixedPattern::Masks FixedPattern::masks() const {
    if (num_images_ < kMinImages) return {};
    const cv::Mat mean = sum_ / num_images_;
    const cv::Mat variance = sum_of_squares_ / num_images_ - mean.mul(mean);
    const cv::Mat is_still = variance < kStill * kStill;
    const cv::Mat surroundings = black_surroundings(mean, is_still);
    const cv::Mat is_inside = ~dilated(surroundings, kRim_px);
    if (cv::countNonZero(is_still & is_inside) > kMaxStillShare * cv::countNonZero(is_inside))
        return {};
    const cv::Mat is_fixed = is_still & (slope_of(mean) > kEdge);
    // Between black and the scene; letters on black have black on both sides.
    const cv::Mat is_border =
        is_fixed & dilated(surroundings, kBlur_px) & dilated(~is_still, kBlur_px);
    const cv::Mat contour = dilated(surroundings, 1) & ~surroundings;
    const cv::Mat edges = is_fixed & ~is_border;
    Masks masks;
    if (cv::countNonZero(edges) >= kMinEdgeShare * static_cast<double>(mean.total()))
        cv::dilate(edges, masks.overlay, rectangle(2 * kReach_px + 1, kReach_px));
    if (cv::countNonZero(contour & dilated(is_border, kBlur_px)) >
            kMinSharpShare * cv::countNonZero(contour) &&
        cv::countNonZero(is_inside) > kMinSceneShare * static_cast<double>(mean.total()))
        masks.border = dilated(surroundings, kRim_px);
    return masks;
}

}  // namespace divemesh::dive
