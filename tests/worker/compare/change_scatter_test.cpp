#include "worker/compare/change_scatter.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <random>

namespace divemesh::compare {
namespace {

// Level ground with a flight of steps across the middle, recorded twice.
class ChangeScatterTest : public testing::Test {
protected:
    static constexpr int kSide = 120;
    static bool on_steps(int column) { return column >= 45 && column < 75; }

    void SetUp() override {
        const auto empty = [](double value) {
            return cv::Mat(kSide, kSide, CV_32F, cv::Scalar::all(value));
        };
        map_ = {{0.01, {0.0, 1.2}, kSide, kSide},
                cv::Mat(kSide, kSide, CV_8U, cv::Scalar::all(3)),
                empty(0.0),
                empty(0.002),
                empty(0.0)};
        a_.height_m = empty(0.0);
        b_.height_m = empty(0.0);
        std::mt19937 random(1);
        std::normal_distribution<float> noise(0.0F, 1.0F);
        for (int row = 0; row < kSide; ++row)
            for (int column = 0; column < kSide; ++column) {
                if (on_steps(column) && column % 4 < 2) a_.height_m.at<float>(row, column) = 0.1F;
                map_.change_m.at<float>(row, column) =
                    noise(random) * (on_steps(column) ? 0.012F : 0.001F);
            }
        a_.height_m.copyTo(b_.height_m);
    }

    ChangeMap map_;
    SurfaceRaster a_;
    SurfaceRaster b_;
};

TEST_F(ChangeScatterTest, SigmaSaysHowFarGroundOfThatKindScatters) {
    scale_by_scatter(map_, a_, b_, 0.04);
    EXPECT_NEAR(map_.sigma_m.at<float>(60, 20), 0.001, 0.0001);
    EXPECT_NEAR(map_.sigma_m.at<float>(60, 60), 0.012, 0.001);
}

TEST_F(ChangeScatterTest, ATenthThatTrulyChangedDoesNotHideTheScatterOfTheRest) {
    for (int row = 0; row < kSide; ++row)
        for (int column = 0; column < 12; ++column) map_.change_m.at<float>(row, column) = 0.2F;
    scale_by_scatter(map_, a_, b_, 0.04);
    EXPECT_LT(map_.sigma_m.at<float>(60, 20), 0.0015);
}

TEST_F(ChangeScatterTest, AFewCellsOfAKindTakeTheFactorOfTheNext) {
    a_.height_m.at<float>(100, 100) = 1.0F;  // a spike
    const auto scatter = scale_by_scatter(map_, a_, b_, 0.02);
    EXPECT_LT(scatter[5].num_cells, 200U);
    EXPECT_EQ(scatter[5].factor, scatter[4].factor);
}

TEST_F(ChangeScatterTest, TooFewCellsToTellLeaveSigmaAsStated) {
    const cv::Rect compared(55, 50, 10, 10);
    const cv::Mat change = map_.change_m(compared).clone();
    map_.change_m = std::numeric_limits<float>::quiet_NaN();
    change.copyTo(map_.change_m(compared));
    scale_by_scatter(map_, a_, b_, 0.04);
    EXPECT_FLOAT_EQ(map_.sigma_m.at<float>(55, 60), 0.002F);
}

}  // namespace
}  // namespace divemesh::compare
