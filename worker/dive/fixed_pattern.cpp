#include "worker/dive/fixed_pattern.hpp"

#include <algorithm>
#include <opencv2/imgproc.hpp>

#include "worker/camera/gradient_magnitude.hpp"
#include "worker/camera/view_details.hpp"
#include "worker/stats/median.hpp"

namespace divemesh::dive {
namespace {

constexpr int kMinImages = 6;
constexpr double kStill = 4.0;           // grey values; standard deviation over time
constexpr double kEdge = 8.0;            // grey values per px
constexpr double kMinEdgeShare = 0.003;  // of the image; moving scenes have up to 0.0009
constexpr double kMaxStillShare = 0.5;   // of what is not black; the rig stands still
// Shares of the edges, and of the cells of the image with edges. A shoal in front of a rig at rest
// left 0.78 and 0.96; overlays and parts of a moving rig up to 0.31 and 0.44.
constexpr double kMinStayingEdges = 0.55;
constexpr double kMinStayingCells = 0.65;
constexpr float kMinTimeSeen = 0.6F;      // share of the images in which an edge stays
constexpr double kNearMedian = 8.0;       // grey values
constexpr float kMinEdgesOfCell = 0.02F;  // share of its pixels
const cv::Size kCells(8, 6);
constexpr double kMaxShareOfOneView = 0.6;  // of the images; more is a rest
constexpr int kReach_px = 25;               // letters that change stand this near to fixed edges
constexpr double kMaxBlack = 16.0;          // grey value of the surroundings of a round image
constexpr int kMinSurroundings_px = 15;     // width; narrower ones are shadows and letters
constexpr double kMinSharpShare = 0.5;      // of the contour; light that fades has no edge
constexpr double kMinSceneShare = 0.02;     // of the image
constexpr int kBlur_px = 4;                 // of the border by the lens
constexpr int kRim_px = 8;                  // half a patch, and the blur

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

// Returns 1 where a mask is 255, CV_32F.
cv::Mat share_of(const cv::Mat& mask) {
    cv::Mat share;
    mask.convertTo(share, CV_32F, 1.0 / 255.0);
    return share;
}

// Returns the median of each pixel over images of one size, CV_32F.
cv::Mat median_of(const std::vector<cv::Mat>& images) {
    cv::Mat median(images.front().size(), CV_32F);
    std::vector<float> values(images.size());
    for (int v = 0; v < median.rows; ++v)
        for (int u = 0; u < median.cols; ++u) {
            std::ranges::transform(images, values.begin(), [&](const cv::Mat& image) {
                return image.at<float>(v, u);
            });
            median.at<float>(v, u) = stats::upper_median(values);
        }
    return median;
}

}  // namespace

void FixedPattern::add(const cv::Mat& image) {
    if (num_images_++ == 0) {
        sum_ = cv::Mat::zeros(image.size(), CV_32F);
        sum_of_squares_ = cv::Mat::zeros(image.size(), CV_32F);
    }
    small_.push_back(camera::small_view(image));
    details_.push_back(camera::view_details(small_.back()));
    cv::accumulate(image, sum_);
    cv::accumulateSquare(image, sum_of_squares_);
}

bool FixedPattern::most_edges_stay() const {
    const cv::Mat median = median_of(small_);
    cv::Mat time_near = cv::Mat::zeros(median.size(), CV_32F);  // share of the images
    cv::Mat edges = cv::Mat::zeros(median.size(), CV_32F);
    const double per_image = 1.0 / static_cast<double>(small_.size());
    for (const cv::Mat& image : small_) {
        cv::Mat difference;
        cv::absdiff(image, median, difference);
        time_near += share_of(difference < kNearMedian) * per_image;
        edges += share_of(camera::gradient_magnitude(image) > kEdge) * per_image;
    }
    const cv::Mat staying =
        share_of((camera::gradient_magnitude(median) > kEdge) & (time_near >= kMinTimeSeen));
    cv::Mat of_cells;
    cv::Mat staying_of_cells;
    cv::resize(edges, of_cells, kCells, 0.0, 0.0, cv::INTER_AREA);
    cv::resize(staying, staying_of_cells, kCells, 0.0, 0.0, cv::INTER_AREA);
    const cv::Mat have_edges = of_cells > kMinEdgesOfCell;
    const cv::Mat stay = have_edges & (staying_of_cells > kMinStayingEdges * of_cells);
    return cv::sum(staying)[0] > kMinStayingEdges * cv::sum(edges)[0] &&
           cv::countNonZero(stay) > kMinStayingCells * cv::countNonZero(have_edges);
}

bool FixedPattern::most_show_one_view() const {
    const double max_num = kMaxShareOfOneView * static_cast<double>(details_.size());
    return std::ranges::any_of(details_, [&](const cv::Mat& view) {
        return static_cast<double>(std::ranges::count_if(details_, [&](const cv::Mat& other) {
                   return camera::is_same_view(view, other);
               })) > max_num;
    });
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
    if (most_edges_stay()) return {};
    const cv::Mat is_fixed = is_still & (camera::gradient_magnitude(mean) > kEdge);
    // Between black and the scene; letters on black have black on both sides.
    const cv::Mat is_border =
        is_fixed & dilated(surroundings, kBlur_px) & dilated(~is_still, kBlur_px);
    const cv::Mat contour = dilated(surroundings, 1) & ~surroundings;
    const cv::Mat edges = is_fixed & ~is_border;
    Masks masks;
    if (cv::countNonZero(edges) >= kMinEdgeShare * static_cast<double>(mean.total()) &&
        !most_show_one_view())
        cv::dilate(edges, masks.overlay, rectangle(2 * kReach_px + 1, kReach_px));
    if (cv::countNonZero(contour & dilated(is_border, kBlur_px)) >
            kMinSharpShare * cv::countNonZero(contour) &&
        cv::countNonZero(is_inside) > kMinSceneShare * static_cast<double>(mean.total()))
        masks.border = dilated(surroundings, kRim_px);
    return masks;
}

}  // namespace divemesh::dive
