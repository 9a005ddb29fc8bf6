#include "worker/texture/seam_membrane.hpp"

#include <algorithm>
#include <opencv2/imgproc.hpp>
#include <vector>

namespace divemesh::texture {
namespace {

constexpr float kMinWeight = 0.1F;  // of a pixel that is held: beside the seam, not far from it

// Returns the pixels within kStrip_px of the seams but not on them.
std::vector<cv::Point> strip_pixels(const cv::Mat& is_free) {
    cv::Mat distance_px;
    cv::distanceTransform(is_free, distance_px, cv::DIST_L2, cv::DIST_MASK_5);
    std::vector<cv::Point> strip;
    for (int row = 0; row < is_free.rows; ++row)
        for (int column = 0; column < is_free.cols; ++column) {
            const float from_seam_px = distance_px.at<float>(row, column);
            if (from_seam_px > 0.0F && from_seam_px < static_cast<float>(kStrip_px))
                strip.emplace_back(column, row);
        }
    return strip;
}

// Solves the Laplace equation over the strip by successive over-relaxation; all other pixels hold
// their value, and no slope crosses the image's edge.
void relax(const std::vector<cv::Point>& strip, cv::Mat& membrane) {
    constexpr int kNumSteps = 24;
    constexpr float kOverRelaxation = 1.5F;  // best for a strip of 10 px
    const int last_row = membrane.rows - 1;
    const int last_column = membrane.cols - 1;
    for (int step = 0; step < kNumSteps; ++step)
        for (const cv::Point& at : strip) {
            auto* row = membrane.ptr<cv::Vec3f>(at.y);
            const cv::Vec3f& above = membrane.ptr<cv::Vec3f>(std::max(0, at.y - 1))[at.x];
            const cv::Vec3f& below = membrane.ptr<cv::Vec3f>(std::min(last_row, at.y + 1))[at.x];
            const cv::Vec3f& left = row[std::max(0, at.x - 1)];
            const cv::Vec3f& right = row[std::min(last_column, at.x + 1)];
            const cv::Vec3f mean = 0.25F * (above + below + left + right);
            row[at.x] += kOverRelaxation * (mean - row[at.x]);
        }
}

}  // namespace

SeamResiduals::SeamResiduals(const cv::Size& size)
    : sums(size, CV_32FC3, cv::Scalar::all(0.0)), weights(size, CV_32F, cv::Scalar::all(0.0)) {}

void add_membrane(const SeamResiduals& residuals, cv::Mat& image) {
    cv::Mat membrane(image.size(), CV_32FC3, cv::Scalar::all(0.0));
    cv::Mat is_free(image.size(), CV_8UC1, cv::Scalar(255));
    for (int row = 0; row < image.rows; ++row)
        for (int column = 0; column < image.cols; ++column) {
            const float weight = residuals.weights.at<float>(row, column);
            if (weight < kMinWeight) continue;
            membrane.at<cv::Vec3f>(row, column) =
                residuals.sums.at<cv::Vec3f>(row, column) / weight;
            is_free.at<std::uint8_t>(row, column) = 0;
        }
    relax(strip_pixels(is_free), membrane);
    image += membrane;
}

}  // namespace divemesh::texture
