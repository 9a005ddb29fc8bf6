#include "worker/camera/image_rectifier.hpp"

#include <opencv2/imgproc.hpp>

#include "worker/base/parallel.hpp"
#include "worker/camera/remap_grey.hpp"

namespace divemesh::camera {

ImageRectifier::ImageRectifier(const RectifiedLens& lens,
                               const types::RectifiedRig& rig,
                               int num_threads)
    : pixels_(rig.height_px, rig.width_px, CV_16SC2),
      parts_(rig.height_px, rig.width_px, CV_16UC1) {
    base::for_each_index(
        num_threads, static_cast<std::size_t>(rig.height_px), [&](std::size_t row) {
            const int v = static_cast<int>(row);
            cv::Mat x(1, rig.width_px, CV_32F);
            cv::Mat y(1, rig.width_px, CV_32F);
            for (int u = 0; u < rig.width_px; ++u) {
                const Eigen::Vector2d pixel = lens.recorded_px(rig, Eigen::Vector2d(u, v));
                x.at<float>(0, u) = static_cast<float>(pixel.x());
                y.at<float>(0, u) = static_cast<float>(pixel.y());
            }
            cv::Mat pixels = pixels_.row(v);
            cv::Mat parts = parts_.row(v);
            cv::convertMaps(x, y, pixels, parts, CV_16SC2);
        });
}

cv::Mat ImageRectifier::rectify(const cv::Mat& image) const {
    if (image.type() == CV_8UC1) return remap_grey(image, pixels_, parts_);
    cv::Mat result;
    cv::remap(image, result, pixels_, parts_, cv::INTER_LINEAR);
    return result;
}

cv::Mat ImageRectifier::rectify_mask(const cv::Mat& mask) const {
    cv::Mat result;
    cv::remap(
        mask, result, pixels_, parts_, cv::INTER_NEAREST, cv::BORDER_CONSTANT, cv::Scalar(255));
    return result;
}

}  // namespace divemesh::camera
