#include "worker/base/pack_rectangles.hpp"

#include <gtest/gtest.h>

#include "schemas/error.hpp"

namespace divemesh::base {
namespace {

std::vector<cv::Size> many_sizes() {
    std::vector<cv::Size> sizes;
    for (int i = 0; i < 200; ++i) sizes.emplace_back(5 + i * 37 % 90, 5 + i * 53 % 70);
    return sizes;
}

TEST(PackRectanglesTest, RectanglesLieOnTheirSheetsAndDoNotOverlap) {
    const std::vector<cv::Size> sizes = many_sizes();
    const RectanglePacking packing = pack_rectangles(sizes, 256);
    EXPECT_GT(packing.sheets.size(), 1U);
    for (std::size_t i = 0; i < sizes.size(); ++i) {
        const cv::Rect place(packing.corners[i], sizes[i]);
        const cv::Rect sheet({}, packing.sheets.at(packing.sheet_of[i]));
        EXPECT_EQ(place & sheet, place) << i;
        EXPECT_LE(std::max(sheet.width, sheet.height), 256);
        for (std::size_t k = 0; k < i; ++k) {
            if (packing.sheet_of[k] != packing.sheet_of[i]) continue;
            EXPECT_TRUE((place & cv::Rect(packing.corners[k], sizes[k])).empty()) << i << " " << k;
        }
    }
}

TEST(PackRectanglesTest, OneSheetThatIsLargeEnoughHoldsAllWithLittleEmpty) {
    int area = 0;
    for (const cv::Size& size : many_sizes()) area += size.area();
    const RectanglePacking packing = pack_rectangles(many_sizes(), 8192);
    ASSERT_EQ(packing.sheets.size(), 1U);
    EXPECT_LT(packing.sheets[0].area(), 1.3 * area);
}

TEST(PackRectanglesTest, NoRectangleNeedsNoSheet) {
    EXPECT_TRUE(pack_rectangles({}, 64).sheets.empty());
}

TEST(PackRectanglesTest, ARectangleThatNoSheetHoldsIsRefused) {
    for (const cv::Size& size : {cv::Size(65, 3), cv::Size(3, 65), cv::Size(0, 3)})
        EXPECT_THROW(pack_rectangles({{2, 2}, size}, 64), Error);
}

}  // namespace
}  // namespace divemesh::base
