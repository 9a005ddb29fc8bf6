#pragma once

#include <array>
#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>
#include <vector>

#include "worker/dive/finding_log.hpp"

namespace divemesh::dive {

// Finds a camera whose images are turned by 180 degrees or mirrored against those of the other, as
// of a camera that is mounted upside down, and a recording that holds the images of one camera
// twice.
class MountingCheck {
public:
    // Adds a pair, 8 bit grey as recorded: corners of the left image, where they were found in the
    // right one, and whether they were.
    void add(const cv::Mat& left,
             const cv::Mat& right,
             const std::vector<cv::Point2f>& corners,
             const std::vector<cv::Point2f>& found_at,
             const std::vector<bool>& found);
    // Adds the pairs of another check.
    void add(const MountingCheck& other);
    void report(FindingLog& findings) const;

private:
    static constexpr std::size_t kNumOrientations = 3;

    int num_corners_ = 0;
    int num_found_ = 0;
    int num_in_place_ = 0;  // found at the same pixel
    std::array<int, kNumOrientations> num_found_turned_{};
};

}  // namespace divemesh::dive
