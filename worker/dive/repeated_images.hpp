#pragma once

#include <deque>
#include <opencv2/core/mat.hpp>
#include <vector>

namespace divemesh::dive {

// Finds images that a recorder wrote again as another frame, or that a camera which hangs gave
// again: they do not show the time of their frames. For the images of one camera, in their order.
class RepeatedImages {
public:
    enum class Kind {
        No,
        Exact,  // to the last bit; a camera that looks at the same scene twice shows other noise
        Reencoded,  // but for its coding, while the scene moves before and after
    };

    // Compares an image, 8 bit grey, with the one before. The first images of a rest may pass for
    // encoded again if they have no noise; these are three at most.
    Kind add(const cv::Mat& image);
    // Learns from images, in their order, how much the scene moves, before any is added.
    void learn(const std::vector<cv::Mat>& first);

private:
    void keep(double difference);
    double usual_motion() const;  // the second largest difference; 0: too few are known
    bool is_reencoded(const cv::Mat& small);

    cv::Mat previous_;
    cv::Mat previous_small_;          // CV_32F, without its mean
    std::deque<double> differences_;  // grey values (RMS), of the last images that count as new
    int num_reencoded_ = 0;           // since the scene moved
};

}  // namespace divemesh::dive
