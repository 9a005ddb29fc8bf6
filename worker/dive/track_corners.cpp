#include "worker/dive/track_corners.hpp"

#include <opencv2/video/tracking.hpp>

namespace divemesh::dive {
namespace {

constexpr double kMaxBackError_px = 0.7;  // between a corner and where it is tracked back to

}  // namespace

std::vector<cv::Point2f> track_corners(const cv::Mat& from,
                                       const cv::Mat& to,
                                       const std::vector<cv::Point2f>& points,
                                       std::vector<bool>& found) {
    const cv::Size window(21, 21);
    std::vector<cv::Point2f> there;
    std::vector<cv::Point2f> back;
    std::vector<unsigned char> went;
    std::vector<unsigned char> came;
    cv::calcOpticalFlowPyrLK(from, to, points, there, went, cv::noArray(), window, 5);
    cv::calcOpticalFlowPyrLK(to, from, there, back, came, cv::noArray(), window, 5);
    for (std::size_t i = 0; i < points.size(); ++i)
        if (went[i] == 0 || came[i] == 0 || cv::norm(back[i] - points[i]) > kMaxBackError_px)
            found[i] = false;
    return there;
}

}  // namespace divemesh::dive
