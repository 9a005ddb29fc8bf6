#include "worker/dive/undo_paeth.hpp"

#include <gtest/gtest.h>

#include <cstdlib>
#include <opencv2/core.hpp>
#include <vector>

namespace divemesh::dive {
namespace {

// The predictor as the PNG specification writes it (9.4).
int paeth_predictor(int a, int b, int c) {
    const int p = a + b - c;
    const int pa = std::abs(p - a);
    const int pb = std::abs(p - b);
    const int pc = std::abs(p - c);
    if (pa <= pb && pa <= pc) return a;
    return pb <= pc ? b : c;
}

cv::Mat filtered(const cv::Mat& image, const cv::Mat& above) {
    cv::Mat result(image.size(), CV_8UC1);
    for (int v = 0; v < image.rows; ++v)
        for (int u = 0; u < image.cols; ++u) {
            const cv::Mat over = v == 0 ? above : image.row(v - 1);
            const int a = u == 0 ? 0 : image.at<std::uint8_t>(v, u - 1);
            const int b = over.at<std::uint8_t>(0, u);
            const int c = u == 0 ? 0 : over.at<std::uint8_t>(0, u - 1);
            result.at<std::uint8_t>(v, u) =
                static_cast<std::uint8_t>(image.at<std::uint8_t>(v, u) - paeth_predictor(a, b, c));
        }
    return result;
}

class UndoPaethTest : public testing::TestWithParam<int> {
protected:
    void SetUp() override {
        image_.create(PaethRows::kNumRows, GetParam(), CV_8UC1);
        above_.create(1, GetParam(), CV_8UC1);
        cv::RNG random(9);
        random.fill(image_, cv::RNG::UNIFORM, 0, 256);
        random.fill(above_, cv::RNG::UNIFORM, 0, 256);
        filtered_ = filtered(image_, above_);
    }

    cv::Mat image_;
    cv::Mat above_;
    cv::Mat filtered_;
};

TEST_P(UndoPaethTest, OneRow) {
    cv::Mat row(1, GetParam(), CV_8UC1);
    PaethRows(GetParam()).undo(filtered_.ptr(), above_.ptr(), row.ptr());
    EXPECT_EQ(cv::norm(row, image_.row(0), cv::NORM_INF), 0.0);
}

TEST_P(UndoPaethTest, EightRowsTwice) {
    PaethRows paeth(GetParam());
    for (int time = 0; time < 2; ++time) {
        cv::Mat rows(image_.size(), CV_8UC1);
        paeth.undo_eight(
            filtered_.ptr(), filtered_.step[0], above_.ptr(), rows.ptr(), rows.step[0]);
        EXPECT_EQ(cv::norm(rows, image_, cv::NORM_INF), 0.0);
    }
}

INSTANTIATE_TEST_SUITE_P(Widths, UndoPaethTest, testing::Values(1, 2, 7, 8, 61, 752));

}  // namespace
}  // namespace divemesh::dive
