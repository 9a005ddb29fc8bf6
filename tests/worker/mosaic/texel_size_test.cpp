#include "worker/mosaic/texel_size.hpp"

#include <gtest/gtest.h>

#include "tests/worker/mosaic/textured_plate.hpp"

namespace divemesh::mosaic {
namespace {

// Returns a plate of 1 m with `num` texels a side.
Plates plate_of(int num) {
    Plates plates;
    plates.add({0, 0}, {1, 1}, 0.0F, {0, 0, 0});
    plates.paint(cv::Mat(num, num, CV_8UC3));
    return plates;
}

double pixel_m(const Plates& plates) { return seen_pixel_m(plates.mesh, plates.texture); }

TEST(TexelSizeTest, APixelIsATexelToATenthOfAMillimetre) {
    EXPECT_DOUBLE_EQ(pixel_m(plate_of(800)), 0.0013);  // 1.25 mm
    EXPECT_DOUBLE_EQ(pixel_m(plate_of(990)), 0.0010);  // 1.01 mm
}

TEST(TexelSizeTest, APixelIsFromHalfAMillimetreToTwo) {
    EXPECT_DOUBLE_EQ(pixel_m(plate_of(4000)), 0.0005);
    EXPECT_DOUBLE_EQ(pixel_m(plate_of(100)), 0.002);
}

TEST(TexelSizeTest, TheLargerAreaDecides) {
    Plates plates = plate_of(1000);
    plates.add({2, 0}, {3.5F, 1}, 0.0F, {0, 0, 0});
    plates.paint(cv::Mat(600, 900, CV_8UC3));  // 1.67 mm

    EXPECT_DOUBLE_EQ(pixel_m(plates), 0.0017);
}

TEST(TexelSizeTest, WhatDoesNotFaceUpwardsDoesNotCount) {
    Plates plates = plate_of(1000);
    plates.add({2, 0}, {4, 2}, 0.0F, {0, 0, 0}, 3.0F);  // steeper than 45 degrees
    plates.paint(cv::Mat(4000, 4000, CV_8UC3));

    EXPECT_DOUBLE_EQ(pixel_m(plates), 0.001);
}

TEST(TexelSizeTest, WithoutPhotographsItIsHalfAnEdge) {
    Plates plates;
    plates.add({0, 0}, {0.0024F, 0.0024F}, 0.0F, {0, 0, 0});

    // First edges: a side and a diagonal, 2.9 mm in the mean.
    EXPECT_DOUBLE_EQ(pixel_m(plates), 0.0014);
    EXPECT_DOUBLE_EQ(seen_pixel_m({}, {}), 0.0005);
}

}  // namespace
}  // namespace divemesh::mosaic
