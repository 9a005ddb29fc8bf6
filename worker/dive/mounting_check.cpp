#include "worker/dive/mounting_check.hpp"

#include <algorithm>
#include <opencv2/core.hpp>
#include <string>

#include "worker/dive/track_corners.hpp"
#include "worker/stats/ratio.hpp"

namespace divemesh::dive {
namespace {

constexpr int kMinCorners = 100;
constexpr double kMaxShareAsRecorded = 0.3;
constexpr double kMinShareTurned = 0.5;
constexpr double kMaxInPlace_px = 0.1;
constexpr double kMinShareInPlace = 0.95;

struct Orientation {
    int flip;  // as in cv::flip
    const char* seen;
    const char* filter;  // of ffmpeg
};
constexpr std::array<Orientation, 3> kOrientations = {
    {{-1, "turned by 180 degrees", "hflip,vflip"},
     {1, "mirrored from left to right", "hflip"},
     {0, "mirrored from top to bottom", "vflip"}}};

}  // namespace

void MountingCheck::add(const cv::Mat& left,
                        const cv::Mat& right,
                        const std::vector<cv::Point2f>& corners,
                        const std::vector<cv::Point2f>& found_at,
                        const std::vector<bool>& found) {
    const auto num_found = static_cast<int>(std::ranges::count(found, true));
    num_corners_ += static_cast<int>(corners.size());
    num_found_ += num_found;
    for (std::size_t i = 0; i < corners.size(); ++i)
        if (found[i] && cv::norm(found_at[i] - corners[i]) < kMaxInPlace_px) ++num_in_place_;
    if (num_found > kMaxShareAsRecorded * static_cast<double>(corners.size())) return;
    for (std::size_t i = 0; i < kNumOrientations; ++i) {
        cv::Mat turned;
        cv::flip(right, turned, kOrientations[i].flip);
        std::vector<bool> found_turned(corners.size(), true);
        track_corners(left, turned, corners, found_turned);
        num_found_turned_[i] += static_cast<int>(std::ranges::count(found_turned, true));
    }
}

void MountingCheck::add(const MountingCheck& other) {
    num_corners_ += other.num_corners_;
    num_found_ += other.num_found_;
    num_in_place_ += other.num_in_place_;
    for (std::size_t i = 0; i < kNumOrientations; ++i)
        num_found_turned_[i] += other.num_found_turned_[i];
}

void MountingCheck::report(FindingLog& findings) const {
    if (num_corners_ < kMinCorners) return;
    if (num_found_ > kMinCorners && stats::ratio(num_in_place_, num_found_) > kMinShareInPlace)
        return findings.error("cameras_identical",
                              "mav0/cam1/data",
                              std::to_string(num_in_place_) + " of " + std::to_string(num_found_) +
                                  " points are at the same pixel in the left and in the right "
                                  "image: both folders hold the images of one camera",
                              "Copy the images of the right camera to mav0/cam1. A recording of "
                              "one camera alone cannot be measured.");
    const auto best = std::ranges::max_element(num_found_turned_);
    if (stats::ratio(num_found_, num_corners_) > kMaxShareAsRecorded ||
        stats::ratio(*best, num_corners_) < kMinShareTurned)
        return;
    const Orientation& orientation =
        kOrientations[static_cast<std::size_t>(best - num_found_turned_.begin())];
    findings.error(
        "camera_turned",
        "mav0/cam1/data",
        std::to_string(num_found_) + " of " + std::to_string(num_corners_) +
            " points of the left images are found in the right ones, but " + std::to_string(*best) +
            " if those are " + orientation.seen,
        std::string("Turn the images of one camera so that both are upright (ffmpeg -vf ") +
            orientation.filter + "), and use a calibration of the turned images.");
}

}  // namespace divemesh::dive
