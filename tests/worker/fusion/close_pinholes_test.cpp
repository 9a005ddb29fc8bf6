#include "worker/fusion/close_pinholes.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>

namespace divemesh::fusion {
namespace {

constexpr float kSigma_px = 0.2F;

// Returns the disparity of a tilted plane.
float plane(int x, int y) {
    return 20.0F + 0.3F * static_cast<float>(x) - 0.1F * static_cast<float>(y);
}

class ClosePinholes : public testing::Test {
protected:
    ClosePinholes() {
        for (int y = 0; y < disparity_px.rows; ++y)
            for (int x = 0; x < disparity_px.cols; ++x) disparity_px.at<float>(y, x) = plane(x, y);
    }
    void clear(const cv::Rect& hole) { disparity_px(hole).setTo(0.0F); }
    int num_unknown() const {
        return static_cast<int>(disparity_px.total()) - cv::countNonZero(disparity_px);
    }

    cv::Mat disparity_px = cv::Mat(40, 60, CV_32F);
    cv::Mat sigma_px = cv::Mat(40, 60, CV_32F, cv::Scalar(kSigma_px));
};

TEST_F(ClosePinholes, AHoleWithinAPlaneGetsThePlane) {
    clear({20, 15, 3, 3});
    close_pinholes(disparity_px, sigma_px);
    EXPECT_EQ(num_unknown(), 0);
    for (int y = 15; y < 18; ++y)
        for (int x = 20; x < 23; ++x) EXPECT_NEAR(disparity_px.at<float>(y, x), plane(x, y), 1e-4F);
}

TEST_F(ClosePinholes, AClosedPixelHasTheLargestSigmaAroundIt) {
    clear({20, 15, 1, 1});
    sigma_px.at<float>(15, 21) = 0.7F;
    close_pinholes(disparity_px, sigma_px);
    EXPECT_FLOAT_EQ(sigma_px.at<float>(15, 20), 0.7F);
    EXPECT_FLOAT_EQ(sigma_px.at<float>(15, 21), 0.7F);
    EXPECT_FLOAT_EQ(sigma_px.at<float>(15, 22), kSigma_px);
}

TEST_F(ClosePinholes, AWideHoleStaysOpenInItsMiddle) {
    clear({20, 10, 12, 12});
    close_pinholes(disparity_px, sigma_px);
    EXPECT_EQ(disparity_px.at<float>(16, 26), 0.0F);
    EXPECT_GT(num_unknown(), 100) << "of 144";
}

TEST_F(ClosePinholes, AHoleBetweenTwoSurfacesStaysOpen) {
    for (int y = 0; y < disparity_px.rows; ++y)
        for (int x = 0; x < disparity_px.cols; ++x)
            disparity_px.at<float>(y, x) = x < 30 ? 20.0F : 28.0F;
    clear({29, 0, 2, 40});
    close_pinholes(disparity_px, sigma_px);
    EXPECT_EQ(num_unknown(), 80);
}

TEST_F(ClosePinholes, ADisparityThatStandsApartBecomesThatOfTheSurface) {
    disparity_px.at<float>(12, 33) += 5.0F;
    close_pinholes(disparity_px, sigma_px);
    EXPECT_NEAR(disparity_px.at<float>(12, 33), plane(33, 12), 1e-4F);
}

TEST_F(ClosePinholes, AThinBarInFrontOfAWallStays) {
    disparity_px.colRange(30, 33) += 8.0F;
    const cv::Mat before = disparity_px.clone();
    close_pinholes(disparity_px, sigma_px);
    EXPECT_EQ(cv::norm(before, disparity_px, cv::NORM_INF), 0.0);
}

// The definition, pixel by pixel.
struct Map {
    cv::Mat disparity_px;
    cv::Mat sigma_px;

    bool has(int x, int y) const {
        return x >= 0 && y >= 0 && x < disparity_px.cols && y < disparity_px.rows &&
               disparity_px.at<float>(y, x) > 0.0F;
    }
    // Returns the distance to the nearest disparity along a direction; 0 beyond 3 px.
    int distance(int x, int y, int dx, int dy) const {
        for (int i = 1; i <= 3; ++i)
            if (has(x + i * dx, y + i * dy)) return i;
        return 0;
    }
};

Map without_single_disparities(const Map& map) {
    Map result{map.disparity_px.clone(), map.sigma_px.clone()};
    for (int y = 1; y + 1 < map.disparity_px.rows; ++y)
        for (int x = 1; x + 1 < map.disparity_px.cols; ++x) {
            int num_alike = -1;  // the pixel itself
            for (int v = y - 1; v <= y + 1; ++v)
                for (int u = x - 1; u <= x + 1; ++u)
                    num_alike += std::abs(map.disparity_px.at<float>(v, u) -
                                          map.disparity_px.at<float>(y, x)) <= 1.0F
                                     ? 1
                                     : 0;
            if (num_alike <= 2) result.disparity_px.at<float>(y, x) = 0.0F;
        }
    return result;
}

Map with_holes_closed(const Map& map) {
    Map result{map.disparity_px.clone(), map.sigma_px.clone()};
    for (int y = 0; y < map.disparity_px.rows; ++y)
        for (int x = 0; x < map.disparity_px.cols; ++x) {
            if (map.has(x, y)) continue;
            int num = 0;
            float sum = 0.0F;
            float min_px = 1e9F;
            float max_px = 0.0F;
            float sigma = 0.0F;
            for (const auto& [dx, dy] :
                 {cv::Point(1, 0), cv::Point(0, 1), cv::Point(1, 1), cv::Point(1, -1)}) {
                const int ahead = map.distance(x, y, dx, dy);
                const int behind = map.distance(x, y, -dx, -dy);
                if (ahead == 0 || behind == 0) continue;
                const cv::Point one(x + ahead * dx, y + ahead * dy);
                const cv::Point other(x - behind * dx, y - behind * dy);
                const float from = map.disparity_px.at<float>(other);
                const float step = map.disparity_px.at<float>(one) - from;
                const auto length = static_cast<float>(ahead + behind);
                if (std::abs(step) > 0.5F * length) continue;
                const float between = from + static_cast<float>(behind) / length * step;
                sum += between;
                min_px = std::min(min_px, between);
                max_px = std::max(max_px, between);
                sigma =
                    std::max({sigma, map.sigma_px.at<float>(one), map.sigma_px.at<float>(other)});
                ++num;
            }
            if (num < 3 || max_px - min_px > 1.0F) continue;
            result.disparity_px.at<float>(y, x) = sum / static_cast<float>(num);
            result.sigma_px.at<float>(y, x) = sigma;
        }
    return result;
}

TEST_F(ClosePinholes, GivesTheBytesOfItsDefinition) {
    cv::RNG random(8);
    for (int y = 0; y < disparity_px.rows; ++y)
        for (int x = 0; x < disparity_px.cols; ++x) {
            // More and more holes to the right, up to the border; a step in the middle.
            const bool known = random.uniform(0, 70) > x;
            disparity_px.at<float>(y, x) =
                known ? plane(x, y) + (y > 20 ? 2.0F : 0.0F) + random.uniform(-0.6F, 0.6F) : 0.0F;
            sigma_px.at<float>(y, x) = known ? random.uniform(0.1F, 1.0F) : 0.0F;
        }
    const Map before{disparity_px.clone(), sigma_px.clone()};
    const Map expected = with_holes_closed(without_single_disparities(before));
    ASSERT_GT(cv::norm(before.disparity_px, expected.disparity_px, cv::NORM_L1), 100.0);

    close_pinholes(disparity_px, sigma_px);

    EXPECT_EQ(cv::norm(disparity_px, expected.disparity_px, cv::NORM_INF), 0.0);
    EXPECT_EQ(cv::norm(sigma_px, expected.sigma_px, cv::NORM_INF), 0.0);
}

}  // namespace
}  // namespace divemesh::fusion
