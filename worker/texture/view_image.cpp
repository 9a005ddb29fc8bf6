#include "worker/texture/view_image.hpp"

#include <opencv2/imgproc.hpp>

#include "schemas/error.hpp"

namespace divemesh::texture {
namespace {

const cv::Size kColorWindow_px(5, 5);
const cv::Size kSharpnessWindow_px(15, 15);

// Returns the image; empty if it cannot be read.
cv::Mat read_or_empty(const keyframes::ReadImage& read_image, int frame_index) {
    try {
        return read_image(frame_index);
    } catch (const Error& error) {
        if (error.code() == ErrorCode::Cancelled) throw;
        return {};
    }
}

// Sobel's operator, whose weights sum to eight for a slope of one.
cv::Mat gradient_magnitude(const cv::Mat& grey) {
    cv::Mat along_x;
    cv::Mat along_y;
    cv::Sobel(grey, along_x, CV_32F, 1, 0, 3, 0.125);
    cv::Sobel(grey, along_y, CV_32F, 0, 1, 3, 0.125);
    cv::Mat magnitude;
    cv::magnitude(along_x, along_y, magnitude);
    return magnitude;
}

}  // namespace

ViewImage read_view_image(const keyframes::ReadImage& read_image, int frame_index) {
    cv::Mat image = read_or_empty(read_image, frame_index);
    if (image.empty()) return {};
    cv::Mat grey = image;
    if (image.channels() == 1)
        cv::cvtColor(grey, image, cv::COLOR_GRAY2BGR);
    else
        cv::cvtColor(image, grey, cv::COLOR_BGR2GRAY);
    ViewImage view;
    cv::blur(image, view.color, kColorWindow_px);
    cv::blur(gradient_magnitude(grey), view.sharpness, kSharpnessWindow_px);
    return view;
}

}  // namespace divemesh::texture
