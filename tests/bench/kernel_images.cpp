#include "tests/bench/kernel_images.hpp"

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace divemesh::bench {
namespace {

ImagePair make_slanted_bed() {
    cv::RNG random(1);
    cv::Mat texture(kHeight_px, kWidth_px + 160, CV_8U);
    random.fill(texture, cv::RNG::UNIFORM, 0, 255);
    cv::GaussianBlur(texture, texture, {7, 7}, 1.5);
    cv::normalize(texture, texture, 0, 255, cv::NORM_MINMAX);
    ImagePair made;
    made.left = texture(cv::Rect(0, 0, kWidth_px, kHeight_px)).clone();
    cv::Mat x(kHeight_px, kWidth_px, CV_32F);
    cv::Mat y(kHeight_px, kWidth_px, CV_32F);
    for (int v = 0; v < kHeight_px; ++v)
        for (int u = 0; u < kWidth_px; ++u) {
            const auto row = static_cast<float>(v);
            const auto column = static_cast<float>(u);
            x.at<float>(v, u) = column + 20.0F + 0.05F * row + 0.02F * column;
            y.at<float>(v, u) = row;
        }
    cv::remap(texture, made.right, x, y, cv::INTER_LINEAR);
    for (cv::Mat* image : {&made.left, &made.right}) {
        cv::Mat noise(image->size(), CV_8S);
        random.fill(noise, cv::RNG::NORMAL, 0.0, 2.0);
        cv::add(*image, noise, *image, cv::noArray(), CV_8U);
    }
    return made;
}

}  // namespace

const ImagePair& slanted_bed() {
    static const ImagePair pair = make_slanted_bed();
    return pair;
}

}  // namespace divemesh::bench
