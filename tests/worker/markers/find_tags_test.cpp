#include "worker/markers/find_tags.hpp"

#include <gtest/gtest.h>

#include "tests/worker/markers/drawn_tags.hpp"

namespace divemesh::markers {
namespace {

double max_error_px(const Tag& found, const DrawnTag& tag, const Eigen::Isometry3d& T_world_cam) {
    double largest = 0.0;
    for (std::size_t i = 0; i < dive::kNumTagCorners; ++i) {
        const Eigen::Vector3d p_cam =
            T_world_cam.inverse() * tag.corner_world(static_cast<dive::TagCorner>(i));
        largest = std::max(largest, (found.corners_px[i] - test_rig().pixel(p_cam)).norm());
    }
    return largest;
}

class FindTagsTest : public testing::TestWithParam<dive::MarkerFamily> {
protected:
    FindTagsTest() {
        tag_.family = GetParam();
        tag_.id = 7;
        tag_.T_world_marker.linear() =
            Eigen::AngleAxisd(0.4, Eigen::Vector3d::UnitZ()).toRotationMatrix();
    }
    DrawnTag tag_;
};

TEST_P(FindTagsTest, CornersAreWhereTheyAreToAFifteenthOfAPixel) {
    for (const double tilt : {0.0, 0.3, -0.5}) {
        const auto T_world_cam = looking_at_origin(0.6, 0.3, tilt);
        const auto found = find_tags(draw({tag_}, T_world_cam, test_rig()), tag_.family);

        ASSERT_EQ(found.size(), 1U) << tilt;
        EXPECT_EQ(found[0].id, 7);
        EXPECT_LT(max_error_px(found[0], tag_, T_world_cam), 1.0 / 15.0) << tilt;
    }
}

TEST_P(FindTagsTest, BlurNoiseAndHazeLeaveAFourthOfAPixel) {
    const auto T_world_cam = looking_at_origin(0.7, -0.5, 0.25);
    const Spoiling turbid{.blur_px = 1.2, .contrast = 0.35, .noise = 4.0};

    const auto found = find_tags(draw({tag_}, T_world_cam, test_rig(), turbid), tag_.family);

    ASSERT_EQ(found.size(), 1U);
    EXPECT_LT(max_error_px(found[0], tag_, T_world_cam), 0.25);
}

TEST_P(FindTagsTest, GroundWithoutTagsHasNone) {
    EXPECT_TRUE(find_tags(draw({}, looking_down({0, 0, 1}, 0, 0), test_rig()), GetParam()).empty());
}

INSTANTIATE_TEST_SUITE_P(Families,
                         FindTagsTest,
                         testing::Values(dive::MarkerFamily::Tag36h11,
                                         dive::MarkerFamily::Tag25h9,
                                         dive::MarkerFamily::TagStandard41h12));

TEST(FindTagsInBadImagesTest, ATagWithASoiledCellIsNone) {
    DrawnTag tag{.id = 3};
    const auto T_world_cam = looking_down({0, 0, 0.6}, 0.0, 0.0);
    cv::Mat image = draw({tag}, T_world_cam, test_rig());
    ASSERT_EQ(find_tags(image, tag.family).size(), 1U);
    const auto cell_px = 100.0 / 8.0;
    cv::rectangle(image,
                  cv::Rect(static_cast<int>(320 - 1.9 * cell_px),
                           static_cast<int>(240 - 1.9 * cell_px),
                           static_cast<int>(1.8 * cell_px),
                           static_cast<int>(1.8 * cell_px)),
                  255,
                  cv::FILLED);

    EXPECT_TRUE(find_tags(image, tag.family).empty());
}

}  // namespace
}  // namespace divemesh::markers
