#include "worker/texture/view_image.hpp"

#include <opencv2/imgproc.hpp>

#include "schemas/error.hpp"
#include "worker/camera/gradient_magnitude.hpp"

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
    cv::blur(camera::gradient_magnitude(grey), view.sharpness, kSharpnessWindow_px);
    return view;
}

}  // namespace divemesh::texture
