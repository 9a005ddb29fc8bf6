#pragma once

#include <algorithm>
#include <opencv2/core/mat.hpp>
#include <vector>

namespace divemesh::stereo {

// An image of floats with a margin of 0 (unknown) all around: windows may reach over the border and
// vectors past the end of a row, if they write only 0 there. Its memory is reused between images.
class PaddedDisparity {
public:
    static constexpr int kMargin_px = 16;

    // Keeps the values if the size stays the same.
    void resize(cv::Size size) {
        if (size == size_) return;
        size_ = size;
        stride_ = size.width + 2 * kMargin_px;
        values_.assign(static_cast<std::size_t>(size.height + 2 * kMargin_px) * stride_, 0.0F);
    }
    // Copies CV_32F values.
    void copy_from(const cv::Mat& values) {
        resize(values.size());
        for (int y = 0; y < values.rows; ++y)
            std::copy_n(values.ptr<float>(y), values.cols, row(y));
    }
    cv::Mat to_mat() const {
        cv::Mat values(size_, CV_32F);
        for (int y = 0; y < values.rows; ++y)
            std::copy_n(row(y), values.cols, values.ptr<float>(y));
        return values;
    }

    cv::Size size() const { return size_; }
    int width() const { return size_.width; }
    int height() const { return size_.height; }
    // Returns row y, from -kMargin_px to height + kMargin_px - 1, with kMargin_px values before and
    // behind.
    float* row(int y) { return values_.data() + offset(y); }
    const float* row(int y) const { return values_.data() + offset(y); }

private:
    std::size_t offset(int y) const {
        return static_cast<std::size_t>(y + kMargin_px) * stride_ + kMargin_px;
    }

    cv::Size size_;
    std::size_t stride_ = 0;
    std::vector<float> values_;
};

}  // namespace divemesh::stereo
