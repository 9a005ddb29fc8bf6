#include "worker/markers/tag_layout.hpp"

#include <gtest/gtest.h>

#include "worker/markers/april_tag.hpp"

namespace divemesh::markers {
namespace {

// Compares with the images that everybody prints: AprilRobotics/apriltag-imgs.
TEST(TagLayoutTest, SizesAreCountedAsThePrintedImagesHaveThem) {
    const TagLayout classic = tag_layout(dive::MarkerFamily::Tag36h11);
    EXPECT_EQ(classic.total_cells, 10);
    EXPECT_EQ(classic.size_cells, 8);
    EXPECT_FALSE(classic.white_within);
    EXPECT_EQ(tag_layout(dive::MarkerFamily::Tag25h9).total_cells, 9);
    EXPECT_EQ(tag_layout(dive::MarkerFamily::Tag25h9).size_cells, 7);
    const TagLayout standard = tag_layout(dive::MarkerFamily::TagStandard41h12);
    EXPECT_EQ(standard.total_cells, 9);
    EXPECT_EQ(standard.size_cells, 5);
    EXPECT_TRUE(standard.white_within);
    const cv::Mat image = tag_image(dive::MarkerFamily::TagStandard41h12, 3);
    EXPECT_EQ(image.at<std::uint8_t>(1, 1), 0);    // black ring
    EXPECT_EQ(image.at<std::uint8_t>(2, 2), 255);  // white inside
}

TEST(MarkerFamilyTest, HasAsManyIdsAsTheLibraryHasCodes) {
    for (const dive::MarkerFamily family : {dive::MarkerFamily::Tag36h11,
                                            dive::MarkerFamily::Tag25h9,
                                            dive::MarkerFamily::TagStandard41h12})
        EXPECT_EQ(dive::num_ids(family), static_cast<int>(make_april_tag_family(family)->ncodes))
            << dive::to_string(family);
}

}  // namespace
}  // namespace divemesh::markers
