#include "worker/features/patch_kernels.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <opencv2/core.hpp>

#include "tests/synthetic/texture.hpp"

namespace divemesh::features {
namespace {

SquarePlace place(const cv::Mat& image, int column, int row, double right, double below) {
    return {image.ptr<std::uint8_t>(row) + column,
            static_cast<std::ptrdiff_t>(image.step[0]),
            static_cast<std::int16_t>(32768.0 * right),
            static_cast<std::int16_t>(32768.0 * below)};
}

// Returns an image that is black and white at random, which gives the largest sums.
cv::Mat extreme_image() {
    cv::Mat image(64, 64, CV_8U);
    cv::RNG random(7);
    random.fill(image, cv::RNG::UNIFORM, 0, 2);
    return image * 255;
}

TEST(PatchKernelsTest, ReadBetweenThePixels) {
    const cv::Mat image = synthetic::textured_image(0.0, 0.0);
    std::array<std::int16_t, kOuterPixels> outer{};
    patch_kernels(base::Instructions::Baseline)
        .read_outer(place(image, 100, 80, 0.3, 0.8), outer.data());
    for (int v = 0; v < kOuterSide_px; ++v) {
        for (int u = 0; u < kOuterSide_px; ++u) {
            const auto at = [&](int du, int dv) {
                return static_cast<double>(image.at<std::uint8_t>(80 + v + dv, 100 + u + du));
            };
            const double expected = 0.7 * 0.2 * at(0, 0) + 0.3 * 0.2 * at(1, 0) +
                                    0.7 * 0.8 * at(0, 1) + 0.3 * 0.8 * at(1, 1);
            const auto read = outer[static_cast<std::size_t>(v * kOuterSide_px + u)];
            EXPECT_NEAR(read / 64.0, expected, 0.05);
        }
    }
}

// Interpolation of an image that is linear has no error, wherever the square is warped to.
TEST(PatchKernelsTest, AWarpedSquareOfALinearImageIsLinear) {
    cv::Mat image(64, 64, CV_8U);
    for (int y = 0; y < image.rows; ++y)
        for (int x = 0; x < image.cols; ++x)
            image.at<std::uint8_t>(y, x) = static_cast<std::uint8_t>(x + 3 * y);
    Eigen::Matrix2d warp;
    warp << 1.1, -0.3, 0.2, 0.9;
    const Eigen::Vector2d centre(30.3, 28.7);
    std::array<std::int16_t, kOuterPixels> outer{};
    patch_kernels(base::Instructions::Baseline)
        .read_warped({image.ptr<std::uint8_t>(), std::ptrdiff_t{64}, centre, warp}, outer.data());
    for (int v = 0; v < kOuterSide_px; ++v)
        for (int u = 0; u < kOuterSide_px; ++u) {
            const Eigen::Vector2d at = centre + warp * Eigen::Vector2d(u - 8.5, v - 8.5);
            const auto read = outer[static_cast<std::size_t>(v * kOuterSide_px + u)];
            EXPECT_NEAR(read / 64.0, at.x() + 3.0 * at.y(), 1.0 / 64.0);
        }
}

TEST(PatchKernelsTest, ThePatchItselfIsSeenAsItself) {
    const cv::Mat image = extreme_image();
    const PatchKernels kernels = patch_kernels(base::Instructions::Baseline);
    std::array<std::int16_t, kOuterPixels> outer{};
    kernels.read_outer(place(image, 10, 12, 0.25, 0.5), outer.data());
    PatchColumns columns;
    const ColumnProducts own = kernels.make_columns(outer.data(), columns);

    const SeenProducts seen = kernels.compare(columns, place(image, 11, 13, 0.25, 0.5));

    EXPECT_EQ(seen.seen, own.value);
    EXPECT_EQ(seen.x_seen, own.x_value);
    EXPECT_EQ(seen.y_seen, own.y_value);
    EXPECT_EQ(seen.value_seen, own.value_value);
    EXPECT_EQ(seen.seen_seen, static_cast<std::uint32_t>(own.value_value));
}

TEST(PatchKernelsTest, EveryInstructionSetGivesTheSameIntegers) {
    if (base::best_instructions() == base::Instructions::Baseline) GTEST_SKIP() << "no AVX2 here";
    const PatchKernels baseline = patch_kernels(base::Instructions::Baseline);
    const PatchKernels avx2 = patch_kernels(base::Instructions::Avx2);
    for (const cv::Mat& image : {extreme_image(), synthetic::textured_image(0.0, 0.0)}) {
        const SquarePlace from = place(image, 20, 9, 0.61, 0.99);
        const SquarePlace to = place(image, 22, 11, 0.07, 0.43);
        std::array<std::int16_t, kOuterPixels> outer{};
        std::array<std::int16_t, kOuterPixels> outer_avx2{};
        PatchColumns columns;
        PatchColumns columns_avx2;
        baseline.read_outer(from, outer.data());
        avx2.read_outer(from, outer_avx2.data());
        EXPECT_EQ(outer, outer_avx2);
        const WarpedPlace warped{image.ptr<std::uint8_t>(),
                                 static_cast<std::ptrdiff_t>(image.step[0]),
                                 {31.2, 30.9},
                                 Eigen::Rotation2Dd(0.4).toRotationMatrix()};
        baseline.read_warped(warped, outer.data());
        avx2.read_warped(warped, outer_avx2.data());
        EXPECT_EQ(outer, outer_avx2);
        const ColumnProducts own = baseline.make_columns(outer.data(), columns);
        const ColumnProducts own_avx2 = avx2.make_columns(outer.data(), columns_avx2);
        EXPECT_TRUE(std::equal(
            columns.gradient_x, columns.gradient_x + kPatchPixels, columns_avx2.gradient_x));
        EXPECT_EQ(own.x_y, own_avx2.x_y);
        EXPECT_EQ(own.value_value, own_avx2.value_value);
        const SeenProducts seen = baseline.compare(columns, to);
        const SeenProducts seen_avx2 = avx2.compare(columns, to);
        EXPECT_EQ(seen.seen, seen_avx2.seen);
        EXPECT_EQ(seen.x_seen, seen_avx2.x_seen);
        EXPECT_EQ(seen.y_seen, seen_avx2.y_seen);
        EXPECT_EQ(seen.value_seen, seen_avx2.value_seen);
        EXPECT_EQ(seen.seen_seen, seen_avx2.seen_seen);
    }
}

}  // namespace
}  // namespace divemesh::features
