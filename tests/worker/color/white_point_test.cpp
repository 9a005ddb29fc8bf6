#include "worker/color/white_point.hpp"

#include <gtest/gtest.h>

#include <cstddef>

namespace divemesh::color {
namespace {

using Surface = std::vector<std::array<double, 3>>;

Surface grey_steps(const std::array<double, 3>& light) {
    Surface surface;
    for (int i = 1; i <= 100; ++i) {
        const double albedo = 0.008 * i;
        surface.push_back({albedo * light[0], albedo * light[1], albedo * light[2]});
    }
    return surface;
}

TEST(WhitePoint, TakesTheColourOfTheLightFromAGreySurface) {
    const WhitePoint point = white_point_of(grey_steps({0.3, 0.9, 0.6}));
    EXPECT_NEAR(point.white[1] / point.white[0], 3.0, 1e-9);
    EXPECT_NEAR(point.white[2] / point.white[0], 2.0, 1e-9);
    for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(point.relative[c], point.relative[0], 1e-9);
}

// A surface with colours of its own, in two lights: rendered with the same white point it is the
// same, although no part of it is grey.
TEST(WhitePoint, OfAnEarlierDiveRendersTheSamePlaceAlike) {
    Surface first;
    Surface later;
    for (int i = 0; i < 200; ++i) {
        const std::array<double, 3> albedo = {0.2 + 0.001 * i, 0.15 + 0.0005 * i, 0.05 + 0.001 * i};
        first.push_back({0.5 * albedo[0], 1.0 * albedo[1], 1.2 * albedo[2]});
        later.push_back({0.2 * albedo[0], 0.9 * albedo[1], 0.4 * albedo[2]});
    }
    const WhitePoint of_first = white_point_of(first);
    const WhitePoint of_later = white_point_like(of_first.relative, later);
    EXPECT_EQ(of_later.relative, of_first.relative);
    for (std::size_t i = 0; i < first.size(); ++i)
        for (std::size_t c = 0; c < 3; ++c)
            EXPECT_NEAR(first[i][c] / of_first.white[c], later[i][c] / of_later.white[c], 1e-9);
}

}  // namespace
}  // namespace divemesh::color
