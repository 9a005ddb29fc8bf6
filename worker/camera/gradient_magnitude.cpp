#include "worker/camera/gradient_magnitude.hpp"

#include <opencv2/imgproc.hpp>

namespace divemesh::camera {

cv::Mat gradient_magnitude(const cv::Mat& grey) {
    constexpr double kScale = 0.125;  // the weights sum to eight for a slope of one
    cv::Mat along_x;
    cv::Mat along_y;
    cv::Sobel(grey, along_x, CV_32F, 1, 0, 3, kScale);
    cv::Sobel(grey, along_y, CV_32F, 0, 1, 3, kScale);
    cv::Mat magnitude;
    cv::magnitude(along_x, along_y, magnitude);
    return magnitude;
}

}  // namespace divemesh::camera
