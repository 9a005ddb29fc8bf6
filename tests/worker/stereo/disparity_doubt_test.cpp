#include "worker/stereo/disparity_doubt.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <opencv2/core.hpp>

namespace divemesh::stereo {
namespace {

// Winners on a slant with steps of all sizes; some of them are unconfirmed, some unknown.
cv::Mat rough_winners(cv::Size size, std::uint64_t seed) {
    cv::RNG random(seed);
    cv::Mat winners_px(size, CV_32F);
    for (int y = 0; y < size.height; ++y)
        for (int x = 0; x < size.width; ++x) {
            const float slant_px = 20.0F + 0.3F * static_cast<float>(x);
            const float step_px = static_cast<float>(x / 17 % 3) * 1.5F;
            const float winner = slant_px + step_px + random.uniform(-0.4F, 0.4F);
            const int kind = random.uniform(0, 30);
            winners_px.at<float>(y, x) = kind == 0 ? 0.0F : kind == 1 ? -winner : winner;
        }
    return winners_px;
}

bool is_doubtful(const cv::Mat& winners_px, int x, int y) {
    if (winners_px.at<float>(y, x) <= 0.0F) return true;
    float min_px = 1e6F;
    float max_px = 0.0F;
    for (int v = std::max(0, y - 1); v <= std::min(winners_px.rows - 1, y + 1); ++v)
        for (int u = std::max(0, x - 1); u <= std::min(winners_px.cols - 1, x + 1); ++u) {
            min_px = std::min(min_px, std::abs(winners_px.at<float>(v, u)));
            max_px = std::max(max_px, std::abs(winners_px.at<float>(v, u)));
        }
    return max_px - min_px > 3.0F;
}

// Returns a coordinate beyond the border as seen in a mirror on its outermost pixel.
int mirrored(int i, int num) {
    if (i < 0) return -i;
    return i < num ? i : 2 * num - 2 - i;
}

TEST(DisparityDoubtTest, GivesTheBytesOfItsDefinitionOnEveryInstructionSet) {
    for (const cv::Size size : {cv::Size(96, 40), cv::Size(61, 37), cv::Size(9, 9)}) {
        const cv::Mat winners_px = rough_winners(size, 3);
        cv::Mat before(size, CV_32F);
        cv::RNG(5).fill(before, cv::RNG::UNIFORM, 0.15, 3.0);
        cv::Mat expected(size, CV_32F);
        for (int y = 0; y < size.height; ++y)
            for (int x = 0; x < size.width; ++x) {
                int num = 0;
                for (int v = y - 4; v <= y + 4; ++v)
                    for (int u = x - 4; u <= x + 4; ++u)
                        num += is_doubtful(
                                   winners_px, mirrored(u, size.width), mirrored(v, size.height))
                                   ? 1
                                   : 0;
                const float doubt_px = 2.5F / 81.0F * static_cast<float>(num);
                const float sigma_px = before.at<float>(y, x);
                expected.at<float>(y, x) = std::sqrt(sigma_px * sigma_px + doubt_px * doubt_px);
            }
        ASSERT_GT(cv::norm(expected, before, cv::NORM_INF), 0.05);
        for (const auto set : {base::Instructions::Baseline, base::best_instructions()}) {
            cv::Mat sigma_px = before.clone();
            add_doubt(winners_px, sigma_px, set);
            EXPECT_EQ(cv::norm(sigma_px, expected, cv::NORM_INF), 0.0);
        }
    }
}

TEST(DisparityDoubtTest, APlaneOfConfirmedWinnersIsNotDoubted) {
    cv::Mat winners_px(30, 40, CV_32F);
    for (int y = 0; y < 30; ++y)
        for (int x = 0; x < 40; ++x)
            winners_px.at<float>(y, x) = 20.0F + 0.5F * static_cast<float>(x + y);
    cv::Mat sigma_px(30, 40, CV_32F, cv::Scalar(0.2F));
    add_doubt(winners_px, sigma_px);
    EXPECT_EQ(cv::norm(sigma_px, cv::Mat(30, 40, CV_32F, cv::Scalar(0.2F)), cv::NORM_INF), 0.0);
}

}  // namespace
}  // namespace divemesh::stereo
