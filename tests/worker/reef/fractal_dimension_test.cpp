#include "worker/reef/fractal_dimension.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "worker/reef/complexity_relation.hpp"

namespace divemesh::reef {
namespace {

double uniform(std::uint64_t& state) {
    state = state * 6364136223846793005ULL + 1442695040888963407ULL;
    return static_cast<double>(state >> 11U) * 0x1.0p-53;
}

// Returns a fractional Brownian surface of Hurst exponent H: waves in random directions whose
// amplitude is proportional to the power H + 1/2 of their length, many per octave (Voss 1985);
// D = 3 - H.
HeightGrid fractional_brownian(double H, std::uint64_t seed) {
    HeightGrid grid{{Eigen::Vector2d::Zero(), 1.0 / 256.0, 257, 257}, {}};
    grid.heights_m.assign(grid.shape.num_nodes(), 0.0);
    constexpr int kNumWaves = 160;
    std::uint64_t state = seed;
    for (int wave = 0; wave < kNumWaves; ++wave) {
        const double frequency = 0.25 * std::pow(2.0, 10.0 * (wave + uniform(state)) / kNumWaves);
        const double angle = 6.2832 * uniform(state);
        const double phase = 6.2832 * uniform(state);
        const double kx = 6.2832 * frequency * std::cos(angle);
        const double ky = 6.2832 * frequency * std::sin(angle);
        for (int row = 0; row < 257; ++row)
            for (int column = 0; column < 257; ++column)
                grid.heights_m[grid.shape.index(column, row)] +=
                    0.02 * std::pow(frequency, -H) *
                    std::cos(kx * grid.shape.x_m(column) + ky * grid.shape.y_m(row) + phase);
    }
    return grid;
}

TEST(FractalDimension, HeightVariationFindsTheExponentOfBrownianSurfaces) {
    for (const double H : {0.3, 0.5, 0.7}) {
        double sum = 0.0;
        for (const std::uint64_t seed : {1, 2, 3, 4})
            sum += fractal_dimension_by_height_variation(fractional_brownian(H, seed), 16.0 / 256.0)
                       .value();
        EXPECT_NEAR(sum / 4.0, 3.0 - H, 0.1) << H;
    }
}

TEST(FractalDimension, CubesOrderBrownianSurfacesByRoughness) {
    const auto cubes = [](double H) {
        return fractal_dimension_by_cubes(fractional_brownian(H, 1), 16.0 / 256.0).value();
    };
    EXPECT_GT(cubes(0.3), cubes(0.5));
    EXPECT_GT(cubes(0.5), cubes(0.7));
}

TEST(FractalDimension, OfAPlaneIsTwo) {
    HeightGrid grid{{Eigen::Vector2d::Zero(), 1.0 / 256.0, 257, 257}, {}};
    for (int row = 0; row < 257; ++row)
        for (int column = 0; column < 257; ++column) grid.heights_m.push_back(0.3 * column / 256.0);
    EXPECT_NEAR(fractal_dimension_by_height_variation(grid, 0.03).value(), 2.0, 1e-9);
    EXPECT_NEAR(fractal_dimension_by_cubes(grid, 0.03).value(), 2.0, 0.1);
}

// The table that habtools prints for a 2 m square of its reef `horseshoe`: D = 2.159332.
TEST(FractalDimension, RegressionGivesWhatHabtoolsPublishes) {
    const std::vector<double> scales = {0.0625, 0.125, 0.25, 0.5, 1.0, 2.0};
    const std::vector<double> ranges = {
        0.07207143, 0.16465515, 0.31394699, 0.58224221, 0.88901201, 1.36828852};
    EXPECT_NEAR(3.0 - log_log_slope(scales, ranges).value(), 2.159332, 1e-6);
}

// rdh_theory(R = 4, H = 1, L = 1, L0 = 0.01) of habtools: D = 2.36928.
TEST(ComplexityRelation, GivesThePublishedExample) {
    EXPECT_NEAR(fractal_dimension_from(4.0, 1.0, {1.0, 0.01}), 2.36928, 1e-5);
    const double range_at_resolution = std::pow(0.01, 3.0 - 2.36928);
    EXPECT_NEAR(rugosity_of_height_range(range_at_resolution, 0.01), 4.0, 1e-4);
}

}  // namespace
}  // namespace divemesh::reef
