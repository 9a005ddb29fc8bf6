#include "worker/steps/track_features.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>

namespace divemesh::worker {
namespace {

constexpr int kPyramidLevels = 3;
constexpr float kBackwardError_px = 0.5F;
constexpr int kBorder_px = 8;
constexpr float kEdge_px = kBorder_px;
constexpr int kCornerBlock_px = 5;
constexpr float kCornerQuality = 0.01F;    // of the best corner of the picture
constexpr float kLeastCornerness = 4e-5F;  // of a picture scaled to 0..1: about its noise
const cv::Size kWindow_px(21, 21);
const cv::TermCriteria kStop(cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 20, 0.01);

constexpr int kContrastBlock_px = 15;
constexpr double kContrastFloor = 6.0;  // grey levels: below it there is noise and JPEG blocks
constexpr double kContrast = 40.0;

// The picture without its brightness and contrast, which caustics, strobes and haze change from
// frame to frame: every pixel against the mean and spread around it.
cv::Mat normalised(const cv::Mat& image) {
    const cv::Size block(kContrastBlock_px, kContrastBlock_px);
    cv::Mat values;
    cv::Mat local;
    image.convertTo(values, CV_32F);
    cv::blur(values, local, block);
    values -= local;
    cv::blur(values.mul(values), local, block);
    cv::sqrt(local, local);
    local += kContrastFloor;
    cv::divide(values, local, values, kContrast);
    cv::Mat result;
    values.convertTo(result, CV_8U, 1.0, 128.0);
    return result;
}

Eigen::Vector3d expected(const RectifiedRig& rig,
                         const Feature& feature,
                         const Eigen::Isometry3d& T_cam_previous) {
    const Eigen::Vector3d p_previous =
        has_depth(feature) ? point_cam(rig, feature)
                           : rig.point_cam(feature.pixel.x(), feature.pixel.y(), 1.0);
    const Eigen::Vector3d p_cam = has_depth(feature)
                                      ? Eigen::Vector3d(T_cam_previous * p_previous)
                                      : Eigen::Vector3d(T_cam_previous.linear() * p_previous);
    if (p_cam.z() < 1e-3) return measurement_px(feature);
    Eigen::Vector3d result = project_px(rig, p_cam);
    if (!has_depth(feature)) result.z() = 0.0;
    return result;
}

bool inside(const cv::Mat& image, const cv::Point2f& point) {
    return point.x >= kEdge_px && point.y >= kEdge_px &&
           point.x < static_cast<float>(image.cols) - kEdge_px &&
           point.y < static_cast<float>(image.rows) - kEdge_px;
}

cv::Point2f to_cv(const Eigen::Vector3d& measurement) {
    return {static_cast<float>(measurement.x()), static_cast<float>(measurement.y())};
}

// Lets a later feature not sit on an earlier one: where tracks run together the older one stays.
class Occupancy {
public:
    Occupancy(const cv::Mat& image, int cell_px)
        : cell_px_(cell_px),
          taken_((image.rows - 1) / cell_px + 1, (image.cols - 1) / cell_px + 1) {
        taken_ = 0;
    }
    bool take(double x, double y) {
        std::uint8_t& taken =
            taken_(static_cast<int>(y) / cell_px_, static_cast<int>(x) / cell_px_);
        const bool free = taken == 0;
        taken = 1;
        return free;
    }

private:
    int cell_px_;
    cv::Mat_<std::uint8_t> taken_;
};

}  // namespace

FeatureTracker::FeatureTracker(const RectifiedRig& rig, const ReconstructionOptions& options)
    : rig_(rig),
      cell_px_(std::max(8,
                        static_cast<int>(std::sqrt(rig.width_px * rig.height_px /
                                                   static_cast<double>(options.num_features))))) {}

Features FeatureTracker::track(const cv::Mat& left,
                               const Features& previous,
                               const Eigen::Isometry3d& T_cam_previous) {
    const std::vector<cv::Mat> previous_pyramid = std::move(pyramid_);
    pyramid_.clear();
    cv::buildOpticalFlowPyramid(normalised(left), pyramid_, kWindow_px, kPyramidLevels);
    left_ = left;
    if (previous.empty() || previous_pyramid.empty()) return {};

    std::vector<cv::Point2f> from;
    std::vector<cv::Point2f> to;
    std::vector<double> disparities;
    for (const Feature& feature : previous) {
        const Eigen::Vector3d guess = expected(rig_, feature, T_cam_previous);
        from.push_back(to_cv(measurement_px(feature)));
        to.push_back(to_cv(guess));
        disparities.push_back(guess.z());
    }
    std::vector<std::uint8_t> found;
    std::vector<std::uint8_t> found_back;
    std::vector<float> error;
    cv::calcOpticalFlowPyrLK(previous_pyramid,
                             pyramid_,
                             from,
                             to,
                             found,
                             error,
                             kWindow_px,
                             kPyramidLevels,
                             kStop,
                             cv::OPTFLOW_USE_INITIAL_FLOW);
    std::vector<cv::Point2f> back = from;
    cv::calcOpticalFlowPyrLK(pyramid_,
                             previous_pyramid,
                             to,
                             back,
                             found_back,
                             error,
                             kWindow_px,
                             1,
                             kStop,
                             cv::OPTFLOW_USE_INITIAL_FLOW);
    Features features;
    Occupancy occupancy(left, std::max(4, cell_px_ / 4));
    for (std::size_t i = 0; i < previous.size(); ++i) {
        const cv::Point2f off = back[i] - from[i];
        if (!found[i] || !found_back[i] || !inside(left, to[i]) ||
            off.dot(off) > kBackwardError_px * kBackwardError_px ||
            !occupancy.take(to[i].x, to[i].y))
            continue;
        features.push_back({previous[i].id, {to[i].x, to[i].y}, disparities[i]});
    }
    return features;
}

Features FeatureTracker::detect(const Features& present) {
    cv::Mat cornerness;
    cv::cornerMinEigenVal(left_, cornerness, kCornerBlock_px);
    double best = 0.0;
    cv::minMaxLoc(cornerness, nullptr, &best);
    const float threshold = std::max(kLeastCornerness, kCornerQuality * static_cast<float>(best));
    Occupancy occupancy(left_, cell_px_);
    for (const Feature& feature : present) occupancy.take(feature.pixel.x(), feature.pixel.y());
    Features features;
    for (int top = kBorder_px; top < left_.rows - kBorder_px; top += cell_px_) {
        for (int start = kBorder_px; start < left_.cols - kBorder_px; start += cell_px_) {
            const cv::Rect cell(start,
                                top,
                                std::min(cell_px_, left_.cols - kBorder_px - start),
                                std::min(cell_px_, left_.rows - kBorder_px - top));
            double value = 0.0;
            cv::Point at;
            cv::minMaxLoc(cornerness(cell), nullptr, &value, nullptr, &at);
            at += cell.tl();
            if (value < threshold || !occupancy.take(at.x, at.y)) continue;
            features.push_back({next_id_++, {at.x, at.y}, 0.0});
        }
    }
    return features;
}

}  // namespace divemesh::worker
