#include "worker/board_calibration/calibrate_rig.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/worker/board_calibration/synthetic_boards.hpp"
#include "worker/board_calibration/length_error.hpp"

namespace divemesh::board_calibration {
namespace {

struct Draw {
    boards::Board board = known_checkerboard();
    RigParameters truth;
    std::vector<boards::BoardView> views;
    RigEstimate estimate;
};

Draw draw(types::Distortion distortion,
          std::uint64_t seed,
          double sigma_px,
          std::optional<types::Distortion> model) {
    std::mt19937_64 random(seed);
    Draw drawn;
    drawn.truth = known_rig(distortion);
    drawn.views = drawn_views(
        drawn.truth, drawn.board, drawn_poses(drawn.board, 80, random), sigma_px, random);
    drawn.estimate = calibrate_rig(drawn.board, drawn.views, {1280, 960}, {1280, 960}, model, {});
    return drawn;
}

double baseline_m(const RigParameters& rig) {
    return isometry_of(rig.T_cam1_cam0).translation().norm();
}

TEST(CalibrateRigTest, WithoutNoiseFindsTheRigExactly) {
    for (const auto distortion :
         {types::Distortion::RadialTangential, types::Distortion::Equidistant}) {
        const Draw drawn = draw(distortion, 1, 0.0, distortion);
        ASSERT_EQ(drawn.estimate.failure, "");
        const RigVector error = drawn.estimate.rig.vector() - drawn.truth.vector();
        EXPECT_LT(error.cwiseAbs().maxCoeff(), 1e-4) << error.transpose();
    }
}

TEST(CalibrateRigTest, ChoosesTheModelOfTheLens) {
    for (const auto distortion :
         {types::Distortion::RadialTangential, types::Distortion::Equidistant}) {
        const Draw drawn = draw(distortion, 2, 0.1, std::nullopt);
        ASSERT_EQ(drawn.estimate.failure, "");
        EXPECT_EQ(drawn.estimate.rig.kind0.distortion, distortion);
        ASSERT_EQ(drawn.estimate.models.size(), 2U);
        EXPECT_LT(drawn.estimate.models[0].left_rms_px, drawn.estimate.models[1].left_rms_px);
        EXPECT_NEAR(drawn.estimate.sigma_px, 0.1, 0.005);
    }
}

TEST(CalibrateRigTest, NamesViewsThatHarmAndLeavesThemOut) {
    std::mt19937_64 random(3);
    const boards::Board board = known_checkerboard();
    const RigParameters truth = known_rig(types::Distortion::RadialTangential);
    auto views = drawn_views(truth, board, drawn_poses(board, 80, random), 0.1, random);
    std::vector<std::int64_t> harmed;
    for (boards::BoardView& view : views) {
        if (view.left.empty() || view.right.empty() || harmed.size() == 3) continue;
        for (auto& corner : view.right) corner.pixel.x() += 6.0;  // the board moved in between
        harmed.push_back(view.timestamp_ns);
    }
    const RigEstimate estimate = calibrate_rig(
        board, views, {1280, 960}, {1280, 960}, types::Distortion::RadialTangential, {});
    ASSERT_EQ(estimate.failure, "");
    std::vector<std::int64_t> named;
    for (const ViewLeftOut& view : estimate.left_out) named.push_back(view.timestamp_ns);
    std::sort(named.begin(), named.end());
    EXPECT_EQ(named, harmed);
    EXPECT_NEAR(baseline_m(estimate.rig) / baseline_m(truth), 1.0, 5e-4);
}

TEST(CalibrateRigTest, LeavesOutSingleCornersThatAreWrong) {
    std::mt19937_64 random(4);
    const boards::Board board = known_checkerboard();
    const RigParameters truth = known_rig(types::Distortion::RadialTangential);
    auto views = drawn_views(truth, board, drawn_poses(board, 80, random), 0.1, random);
    int num_moved = 0;
    for (boards::BoardView& view : views)
        if (!view.left.empty() && ++num_moved % 4 == 0) view.left[5].pixel.y() += 1.5;
    const RigEstimate estimate = calibrate_rig(
        board, views, {1280, 960}, {1280, 960}, types::Distortion::RadialTangential, {});
    ASSERT_EQ(estimate.failure, "");
    EXPECT_EQ(estimate.num_corners_left_out, num_moved / 4);
}

TEST(CalibrateRigTest, SaysWhyTooFewViewsAreNotEnough) {
    std::mt19937_64 random(5);
    const boards::Board board = known_checkerboard();
    const auto views = drawn_views(known_rig(types::Distortion::RadialTangential),
                                   board,
                                   drawn_poses(board, 2, random),
                                   0.1,
                                   random);
    const RigEstimate estimate =
        calibrate_rig(board, views, {1280, 960}, {1280, 960}, std::nullopt, {});
    EXPECT_NE(estimate.failure.find("fewer than 3 pairs"), std::string::npos) << estimate.failure;
    EXPECT_NE(calibrate_rig(board, {}, {1280, 960}, {1280, 960}, std::nullopt, {}).failure, "");
}

}  // namespace
}  // namespace divemesh::board_calibration
