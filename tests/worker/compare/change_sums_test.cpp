#include "worker/compare/change_sums.hpp"

#include <gtest/gtest.h>

#include "tests/worker/compare/level_ground_map.hpp"

namespace divemesh::compare {
namespace {

// 2 m by 2 m in cells of 2 cm.
constexpr int kSide = 100;
constexpr double kTilt = 1e-3;  // rad
constexpr double kShift_m = 0.5e-3;

ChangeMap map_with(const Matrix6d& covariance) {
    return level_ground_map(0.02, kSide, kSide, 0.002F, covariance);
}

cv::Mat all_cells() { return cv::Mat(kSide, kSide, CV_8U, cv::Scalar::all(255)); }

cv::Mat northern_half() {
    cv::Mat cells = all_cells();
    cells.rowRange(kSide / 2, kSide) = cv::Scalar::all(0);
    return cells;
}

double registration_m3(const ChangeMap& map, const cv::Mat& cells) {
    return map.registration_sigma(sum_over(map, cells).by_motion);
}

TEST(ChangeSumsTest, ATiltCancelsOverGroundAroundThePivotAndNotOverOneSideOfIt) {
    const ChangeMap map = map_with(independent({kTilt, kTilt, kTilt, 0.0, 0.0, kShift_m}));
    EXPECT_NEAR(registration_m3(map, all_cells()), 4.0 * kShift_m, 1e-8);
    const double lever_m3 = 2.0 * 0.5;  // area by the mean distance from the pivot
    EXPECT_NEAR(
        registration_m3(map, northern_half()), std::hypot(lever_m3 * kTilt, 2.0 * kShift_m), 1e-8);
}

TEST(ChangeSumsTest, CorrelatedErrorsThatCancelDoNotWidenASum) {
    // The tilt about x always comes with a fall that leaves the height 0.5 m to the north as it is.
    Vector6d motion = Vector6d::Zero();
    motion[0] = kTilt;
    motion[5] = -0.5 * kTilt;
    const ChangeMap map = map_with(motion * motion.transpose());
    EXPECT_NEAR(registration_m3(map, northern_half()), 0.0, 1e-8);
    EXPECT_NEAR(registration_m3(map, all_cells()), 4.0 * 0.5 * kTilt, 1e-8);
}

TEST(ChangeSumsTest, AShiftChangesTheVolumeOfASlopeAndNotThatOfARidge) {
    ChangeMap map = map_with(independent({0.0, 0.0, 0.0, kShift_m, 0.0, 0.0}));
    for (int row = 0; row < kSide; ++row)
        for (int column = 0; column < kSide; ++column)
            map.later_surface.at<cv::Vec3f>(row, column)[0] = column < kSide / 2 ? 0.4F : -0.4F;
    EXPECT_NEAR(registration_m3(map, all_cells()), 0.0, 1e-8);
    cv::Mat western_half = all_cells();
    western_half.colRange(kSide / 2, kSide) = cv::Scalar::all(0);
    EXPECT_NEAR(registration_m3(map, western_half), 2.0 * 0.4 * kShift_m, 1e-8);
}

TEST(ChangeSumsTest, APartOfAMapKnowsItsPlace) {
    ChangeMap map = map_with(independent({kTilt, kTilt, kTilt, kShift_m, kShift_m, kShift_m}));
    map.later_surface.setTo(cv::Scalar(0.3, -0.2, 0.1));
    const cv::Rect window(10, 20, 30, 40);
    cv::Mat cells = cv::Mat::zeros(kSide, kSide, CV_8U);
    cells(window) = cv::Scalar::all(255);
    const Vector6d expected = sum_over(map, cells).by_motion;
    const Vector6d found = sum_over(window_of(map, window), cells(window)).by_motion;
    EXPECT_LT((found - expected).norm(), 1e-9);
}

}  // namespace
}  // namespace divemesh::compare
