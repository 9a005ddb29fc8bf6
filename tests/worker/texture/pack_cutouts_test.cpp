#include "worker/texture/pack_cutouts.hpp"

#include <gtest/gtest.h>

#include <opencv2/core.hpp>
#include <random>

#include "schemas/error.hpp"

namespace divemesh::texture {
namespace {

std::vector<Cutout> random_cutouts(int num, int max_side_px) {
    std::mt19937 random(1);
    std::uniform_int_distribution<int> side(1, max_side_px);
    std::vector<Cutout> cutouts;
    for (int i = 0; i < num; ++i) cutouts.push_back({0, {i, 2 * i, side(random), side(random)}});
    return cutouts;
}

std::int64_t bytes_of(const AtlasPlan& plan) {
    std::int64_t sum = 0;
    for (const cv::Size& size : plan.sizes) sum += 3 * std::int64_t{size.width} * size.height;
    return sum;
}

// Counts texels that belong to no cutout, and fails where two cutouts share one.
std::int64_t num_empty(const AtlasPlan& plan) {
    std::int64_t num = 0;
    for (std::size_t atlas = 0; atlas < plan.sizes.size(); ++atlas) {
        cv::Mat count(plan.sizes[atlas], CV_8UC1, cv::Scalar(0));
        const cv::Rect all({}, count.size());
        for (const PlacedCutout& place : plan.places) {
            if (place.atlas != static_cast<std::int32_t>(atlas)) continue;
            EXPECT_EQ(place.texels & all, place.texels);
            count(place.texels) += cv::Scalar(1);
        }
        double most = 0.0;
        cv::minMaxLoc(count, nullptr, &most);
        EXPECT_LE(most, 1.0);
        num += static_cast<std::int64_t>(count.total()) - cv::countNonZero(count);
    }
    return num;
}

TEST(PackCutouts, FillsOneAtlasNoLargerThanNeeded) {
    const AtlasPlan plan = pack_cutouts(random_cutouts(2000, 60), {});
    ASSERT_EQ(plan.sizes.size(), 1U);
    EXPECT_DOUBLE_EQ(plan.texels_per_pixel, 1.0);
    EXPECT_LT(static_cast<double>(num_empty(plan)), 0.1 * plan.sizes[0].area());
    for (const PlacedCutout& place : plan.places)
        EXPECT_EQ(place.texels.size(), place.pixels.size());
}

TEST(PackCutouts, TakesAsManyAtlasesAsTheirLargestSideAsksFor) {
    AtlasOptions options;
    options.max_side_px = 512;
    const AtlasPlan plan = pack_cutouts(random_cutouts(2000, 60), options);
    EXPECT_GT(plan.sizes.size(), 5U);
    for (const cv::Size& size : plan.sizes) EXPECT_LE(std::max(size.width, size.height), 512);
    for (const PlacedCutout& place : plan.places) EXPECT_NE(place.atlas, PlacedCutout::kNoRoom);
    num_empty(plan);
}

TEST(PackCutouts, ShrinksAllCutoutsAlikeToStayWithinTheBytes) {
    const std::vector<Cutout> cutouts = random_cutouts(500, 300);
    AtlasOptions options;
    options.max_texel_bytes = bytes_of(pack_cutouts(cutouts, {})) / 4;
    const AtlasPlan plan = pack_cutouts(cutouts, options);
    EXPECT_LE(bytes_of(plan), options.max_texel_bytes);
    EXPECT_GT(bytes_of(plan), options.max_texel_bytes * 8 / 10);
    EXPECT_NEAR(plan.texels_per_pixel, 0.5, 0.05);
    for (const PlacedCutout& place : plan.places) {
        EXPECT_NE(place.atlas, PlacedCutout::kNoRoom);
        EXPECT_NEAR(place.texels.width, plan.texels_per_pixel * place.pixels.width, 1.0);
    }
}

TEST(PackCutouts, ShrinksACutoutThatIsLargerThanAnAtlas) {
    AtlasOptions options;
    options.max_side_px = 64;
    const AtlasPlan plan = pack_cutouts({{0, {0, 0, 4000, 3000}}}, options);
    ASSERT_EQ(plan.sizes.size(), 1U);
    EXPECT_LE(plan.sizes[0].width, 64);
    EXPECT_GE(plan.sizes[0].width, 60);
}

TEST(PackCutouts, LeavesOutWhatHasNoRoomAtAll) {
    AtlasOptions options;
    options.max_texel_bytes = 0;
    const AtlasPlan plan = pack_cutouts(random_cutouts(10, 30), options);
    EXPECT_TRUE(plan.sizes.empty());
    for (const PlacedCutout& place : plan.places) EXPECT_EQ(place.atlas, PlacedCutout::kNoRoom);
    EXPECT_TRUE(pack_cutouts({}, {}).sizes.empty());
}

TEST(PackCutouts, ATexelIsTheSamePlaceAsItsPixelAtAnyScale) {
    const PlacedCutout place = {0, {100, 50, 40, 20}, {7, 9, 20, 10}};
    const Eigen::Vector2d corner(99.5, 49.5);  // the outer corner of the first pixel
    EXPECT_TRUE(place.texel(corner).isApprox(Eigen::Vector2d(6.5, 8.5)));
    EXPECT_TRUE(place.texel({139.5, 69.5}).isApprox(Eigen::Vector2d(26.5, 18.5)));
}

TEST(PackCutouts, RefusesWrongLimits) {
    EXPECT_THROW(pack_cutouts({}, {.max_side_px = 63}), Error);
    EXPECT_THROW(pack_cutouts({}, {.max_side_px = 32769}), Error);
    EXPECT_THROW(pack_cutouts({}, {.max_texel_bytes = -1}), Error);
}

}  // namespace
}  // namespace divemesh::texture
