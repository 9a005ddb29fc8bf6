#include "worker/stereo/refine_from_views.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "tests/worker/stereo/wall_views.hpp"
#include "worker/stats/median.hpp"

namespace divemesh::stereo {
namespace {

constexpr float kSigma_px = 0.4F;

// The wall as a pair measured it: each square of 20 px is off by another amount.
struct NoisyWall : WallViews {
    explicit NoisyWall(const Shade& shade = textured) : WallViews(shade) {
        std::mt19937 random(3);
        std::normal_distribution<float> error_px(0.0F, kSigma_px);
        depth.disparity_px = true_disparity_px();
        for (int v = 0; v < 240; v += 20)
            for (int u = 0; u < 320; u += 20)
                depth.disparity_px(cv::Rect(u, v, 20, 20)) += error_px(random);
        depth.sigma_disparity_px = cv::Mat(240, 320, CV_32F, cv::Scalar(kSigma_px));
    }
    int refine(Density density, base::Instructions instructions = base::best_instructions()) {
        return refine_from_views(rig(), left, neighbours, density, depth, instructions);
    }
    // Returns the absolute errors within a part that all frames see.
    std::vector<double> errors_px() const {
        const cv::Rect seen(60, 30, 200, 180);
        const cv::Mat difference_px = cv::abs(depth.disparity_px - true_disparity_px());
        std::vector<double> errors;
        for (int v = seen.y; v < seen.br().y; ++v)
            for (int u = seen.x; u < seen.br().x; ++u)
                errors.push_back(difference_px.at<float>(v, u));
        return errors;
    }

    types::DepthMap depth;
};

bool are_equal(const cv::Mat& a, const cv::Mat& b) { return cv::norm(a, b, cv::NORM_INF) == 0.0; }

class RefineFromViews : public testing::TestWithParam<Density> {};

TEST_P(RefineFromViews, BringsDisparitiesToTheTruth) {
    NoisyWall wall;
    const double before_px = stats::upper_median(wall.errors_px());
    EXPECT_GT(wall.refine(GetParam()), 200 * 180 * 9 / 10);
    EXPECT_LT(stats::upper_median(wall.errors_px()), 0.3 * before_px);
}

TEST_P(RefineFromViews, StatesSigmasThatHold) {
    NoisyWall wall;
    wall.refine(GetParam());
    const cv::Mat truth_px = true_disparity_px();
    int num_held = 0, num_all = 0;
    for (int v = 30; v < 210; ++v)
        for (int u = 60; u < 260; ++u, ++num_all) {
            const float error_px =
                std::abs(wall.depth.disparity_px.at<float>(v, u) - truth_px.at<float>(v, u));
            if (error_px < 2.0F * wall.depth.sigma_disparity_px.at<float>(v, u)) ++num_held;
        }
    EXPECT_GT(num_held, num_all * 9 / 10);
}

TEST_P(RefineFromViews, LeavesWhatTheFramesContradict) {
    NoisyWall wall;
    const cv::Rect wrong(120, 80, 40, 40);
    wall.depth.disparity_px(wrong) += 6.0F;
    const cv::Mat before_px = wall.depth.disparity_px.clone();
    wall.refine(GetParam());
    cv::Mat is_changed = wall.depth.disparity_px(wrong) != before_px(wrong);
    EXPECT_LT(cv::countNonZero(is_changed), wrong.area() / 20);
}

TEST_P(RefineFromViews, LeavesWhatMoves) {
    NoisyWall wall;
    const cv::Mat before_px = wall.depth.disparity_px.clone();
    double shift_m = 50.0;
    const auto cameras = WallViews::cameras();
    for (std::size_t i = 0; i < cameras.size(); ++i, shift_m += 50.0)
        wall.neighbours[i].left = photograph(
            cameras[i],
            [&](double x_m, double y_m) { return textured(x_m + shift_m, y_m); },
            static_cast<unsigned>(i) + 2);
    EXPECT_LT(wall.refine(GetParam()), 320 * 240 / 100);
}

TEST_P(RefineFromViews, LeavesSurfaceWithoutTexture) {
    NoisyWall wall([](double, double) { return 0.0; });
    EXPECT_LT(wall.refine(GetParam()), 320 * 240 / 100);
}

TEST_P(RefineFromViews, GivesTheSameWithEveryInstructionSet) {
    NoisyWall baseline, best;
    baseline.refine(GetParam(), base::Instructions::Baseline);
    best.refine(GetParam());
    EXPECT_TRUE(are_equal(baseline.depth.disparity_px, best.depth.disparity_px));
    EXPECT_TRUE(are_equal(baseline.depth.sigma_disparity_px, best.depth.sigma_disparity_px));
}

TEST_P(RefineFromViews, NeedsTwoFrames) {
    NoisyWall wall;
    wall.neighbours.resize(1);
    EXPECT_EQ(wall.refine(GetParam()), 0);
}

INSTANTIATE_TEST_SUITE_P(Density,
                         RefineFromViews,
                         testing::Values(Density::Grid, Density::EveryPixel),
                         [](const auto& of) {
                             return of.param == Density::Grid ? "Grid" : "EveryPixel";
                         });

}  // namespace
}  // namespace divemesh::stereo
