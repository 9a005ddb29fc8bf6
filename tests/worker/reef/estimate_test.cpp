#include "worker/stats/estimate.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <random>

#include "tests/worker/reef/sheets.hpp"
#include "worker/reef/area_plane.hpp"
#include "worker/reef/heights.hpp"
#include "worker/reef/noise_level.hpp"
#include "worker/reef/rugosity.hpp"
#include "worker/reef/simulate_metrics.hpp"
#include "worker/reef/surface_noise.hpp"
#include "worker/reef/terrain.hpp"

namespace divemesh::reef {
namespace {

constexpr double kSigma_m = 0.004;
constexpr double kCorrelationLength_m = 0.02;

// Noise made in another way: white noise on a square lattice of the plane, blurred by a Gaussian so
// that the correlation is a Gaussian of the distance, 1/e at the correlation length.
class SpreadNoise {
public:
    explicit SpreadNoise(std::uint64_t seed) : random_(seed) {
        for (double& node : nodes_) node = normal_(random_);
    }
    double at(const Eigen::Vector3d& place) const {
        const auto column = static_cast<int>(std::lround(place.x() / kStep_m)) + kNum / 4;
        const auto row = static_cast<int>(std::lround(place.y() / kStep_m)) + kNum / 4;
        double sum = 0.0;
        double squares = 0.0;
        for (int y = row - 4; y <= row + 4; ++y)
            for (int x = column - 4; x <= column + 4; ++x) {
                const double dx = (x - kNum / 4) * kStep_m - place.x();
                const double dy = (y - kNum / 4) * kStep_m - place.y();
                const double weight = std::exp(-2.0 * (dx * dx + dy * dy) /
                                               (kCorrelationLength_m * kCorrelationLength_m));
                sum += weight * nodes_[y * kNum + x];
                squares += weight * weight;
            }
        return sum / std::sqrt(squares);
    }

private:
    static constexpr double kStep_m = 0.008;
    static constexpr int kNum = 160;

    std::mt19937_64 random_;
    std::normal_distribution<double> normal_;
    std::array<double, kNum * kNum> nodes_;
};

double sine(double x, double y) {
    return 0.03 * std::sin(2.0 * std::numbers::pi * x / 0.3) *
           std::cos(2.0 * std::numbers::pi * y / 0.4);
}

struct Setting {
    AreaPlane plane = plane_of(quadrat("q", 0.0, 0.6));
    GridShape fine = grid_over(plane.outline, 0.05);
    GridShape coarse = grid_over(plane.outline, 0.1);

    std::vector<double> metrics(const SurfacePatch& patch, const Places& places) const {
        const HeightGrid grid = sample_heights(places[0], patch.triangles, fine);
        return {rugosity(grid).value(),
                rugosity(sample_heights(places[0], patch.triangles, coarse)).value(),
                volume_over_plane(grid) + 1.0,
                terrain(grid)->mean_slope,
                terrain(grid)->vrm};
    }
};

SurfacePatch exact_patch(const Setting& setting) {
    types::Mesh mesh =
        sheet(0.66, 0.015, [](double x, double y) { return sine(x - 0.03, y - 0.03); });
    for (Eigen::Vector3f& vertex : mesh.vertices) vertex -= Eigen::Vector3f(0.03F, 0.03F, 0.0F);
    mesh.sigma_m.assign(mesh.vertices.size(), static_cast<float>(kSigma_m));
    return cut_patch(mesh, setting.plane, 0.05);
}

SurfacePatch noisy_patch(const Setting& setting, std::uint64_t seed) {
    SurfacePatch patch = exact_patch(setting);
    const SpreadNoise noise(seed);
    for (std::size_t i = 0; i < patch.vertices.size(); ++i)
        patch.vertices[i] += kSigma_m * noise.at(patch.vertices[i]) * patch.normals[i];
    return patch;
}

TEST(EstimateTest, IntervalsHoldTheTruthInNinetyFiveOfAHundredSurfaces) {
    const Setting setting;
    const SurfacePatch exact = exact_patch(setting);
    const std::vector<double> truth = setting.metrics(exact, {exact.vertices});
    MeasureOptions options;
    options.num_replicates = 40;
    constexpr int kNumSeeds = 100;
    std::vector<int> num_held(truth.size(), 0);
    double raised = 0.0;
    for (int seed = 1; seed <= kNumSeeds; ++seed) {
        const SurfacePatch patch = noisy_patch(setting, seed);
        const auto simulated = simulate_metrics(
            {patch}, kCorrelationLength_m, false, options, [&](const Places& places, int) {
                return setting.metrics(patch, places);
            });
        raised += (simulated[0].measured - truth[0]) / kNumSeeds;
        for (std::size_t k = 0; k < truth.size(); ++k) {
            const stats::Estimate estimated = stats::estimate(simulated[k], 0.0);
            if (estimated.low <= truth[k] && truth[k] <= estimated.high) ++num_held[k];
        }
    }
    EXPECT_GT(raised, 0.005);  // if left in, no interval would hold the truth
    for (std::size_t k = 0; k < truth.size(); ++k) {
        EXPECT_GE(num_held[k], 90) << "metric " << k;
        EXPECT_LE(num_held[k], 99) << "metric " << k;
    }
}

TEST(EstimateTest, EqualsTheMeasurementWithoutNoise) {
    const stats::Estimate exact = stats::estimate({1.5, 1.5, {}, {}}, 0.25);
    EXPECT_EQ(exact.value, 1.5);
    EXPECT_EQ(exact.low, 1.5);
    EXPECT_EQ(exact.high, 1.5);
}

TEST(EstimateTest, SharpeningWidensTheInterval) {
    const stats::Estimate sharper = stats::estimate({1.40, 1.45, {}, {}}, 0.25);
    EXPECT_NEAR(sharper.value, 1.45, 1e-12);
    EXPECT_NEAR(sharper.high - sharper.low, 2.0 * 1.96 * 0.05, 1e-4);
}

TEST(EstimateTest, ErrorsThatAllVerticesShareWidenTheIntervalAndMoveNothing) {
    const stats::Estimate area = stats::estimate({2.0, 2.0, {}, {}}, 0.25, {0.003, 0.008});
    EXPECT_EQ(area.value, 2.0);
    EXPECT_NEAR(area.high - area.low, 2.0 * 1.96 * 0.01, 1e-4);
}

TEST(EstimateTest, SharpeningFindsAParabolaOfTheBlurAndStaysWithinTwiceTheFirstStep) {
    const auto parabola = [](double t) { return 2.0 - 0.3 * t + 0.05 * t * t; };
    EXPECT_NEAR(
        stats::sharpened(parabola(1.0), parabola(2.0), parabola(3.0)), parabola(0.0), 1e-12);
    EXPECT_NEAR(stats::sharpened(1.4, 1.3, 1.1), 1.5, 1e-12);
    EXPECT_NEAR(stats::sharpened(1.4, 1.3, 1.35), 1.6, 1e-12);
    EXPECT_EQ(stats::sharpened(1.4, 1.4, 1.4), 1.4);
}

// A mesh of ground that no camera resolves: sines as fine as the blur's side and finer. The
// rugosity lost by the blur is restored better than by Tukey's twicing.
TEST(EstimateTest, SharpeningBringsBackRugosityThatABlurTook) {
    constexpr double kSide_m = 0.03;
    GridShape shape{Eigen::Vector2d::Zero(), 0.002, 401, 401};
    HeightGrid ground{shape, std::vector<double>(shape.num_nodes())};
    for (int row = 0; row < shape.num_rows; ++row)
        for (int column = 0; column < shape.num_columns; ++column) {
            double height = 0.0;  // amplitudes decrease with the wavelength, as in a fractal
            for (const double wavelength : {0.4, 0.2, 0.1, 0.05})
                height += 0.2 * wavelength *
                          std::sin(2.0 * std::numbers::pi * shape.x_m(column) / wavelength) *
                          std::cos(2.0 * std::numbers::pi * shape.y_m(row) / wavelength);
            ground.heights_m[shape.index(column, row)] = height;
        }
    const auto at_5_cm = [](const HeightGrid& grid) { return rugosity(every(grid, 25)).value(); };
    const double truth = at_5_cm(ground);
    const HeightGrid once = blurred(ground, kSide_m);
    const HeightGrid twice = blurred(once, kSide_m);
    const double measured = at_5_cm(once);
    const double sharp =
        stats::sharpened(measured, at_5_cm(twice), at_5_cm(blurred(twice, kSide_m)));
    EXPECT_LT(measured, 0.98 * truth);
    EXPECT_LT(std::abs(sharp - truth), 0.5 * std::abs(2.0 * measured - at_5_cm(twice) - truth));
}

TEST(HeightGrid, BlurringIsTheMeanOfWhatIsSeenWithinTheSquare) {
    GridShape shape{Eigen::Vector2d::Zero(), 0.01, 9, 7};
    HeightGrid grid{shape, std::vector<double>(shape.num_nodes())};
    std::mt19937_64 random(5);
    std::uniform_real_distribution<double> uniform;
    for (double& height : grid.heights_m)
        height = uniform(random) < 0.2 ? kUnseen_m : uniform(random);
    const HeightGrid means = blurred(grid, 0.04);
    for (int row = 0; row < shape.num_rows; ++row)
        for (int column = 0; column < shape.num_columns; ++column) {
            if (!grid.is_seen(column, row)) {
                EXPECT_FALSE(means.is_seen(column, row));
                continue;
            }
            double sum = 0.0, num = 0.0;
            for (int y = std::max(0, row - 2); y <= std::min(shape.num_rows - 1, row + 2); ++y)
                for (int x = std::max(0, column - 2);
                     x <= std::min(shape.num_columns - 1, column + 2);
                     ++x)
                    if (grid.is_seen(x, y)) {
                        sum += grid.at(x, y);
                        num += 1.0;
                    }
            EXPECT_NEAR(means.at(column, row), sum / num, 1e-12);
        }
}

// Returns the noise level of a patch whose noise is a share of what its vertices state.
double noise_level_share(const HeightOf& height, double noise_share) {
    const Setting setting;
    types::Mesh mesh = sheet(0.66, 0.01, height);
    mesh.sigma_m.assign(mesh.vertices.size(), static_cast<float>(kSigma_m));
    SurfacePatch patch = cut_patch(mesh, setting.plane, 0.05);
    patch.vertices =
        with_noise(patch, patch.sigma_local_m, NoiseField(kCorrelationLength_m, 3), noise_share);
    NoiseLevel shown(kCorrelationLength_m);
    shown.add(patch, grid_over(setting.plane.outline, 0.005));
    return shown.share();
}

TEST(NoiseLevel, OnSmoothGroundIsTheShareThatIsThere) {
    const auto slope = [](double x, double y) { return 0.1 * x - 0.05 * y; };
    EXPECT_NEAR(noise_level_share(slope, 0.3), 0.3, 0.06);
    EXPECT_NEAR(noise_level_share(slope, 0.8), 0.8, 0.15);
    EXPECT_EQ(noise_level_share(slope, 1.5), 1.0);
    EXPECT_NEAR(noise_level_share(slope, 0.0), 0.0, 1e-4);
}

TEST(NoiseLevel, OnRoughGroundIsNeverLessThanWhatIsThere) {
    EXPECT_GE(noise_level_share(sine, 0.5), 0.45);
}

TEST(NoiseField, HasVarianceOneAndFallsToOneOverEAtItsLength) {
    double square = 0.0;
    double product = 0.0;
    constexpr int kNum = 20'000;
    for (int i = 0; i < kNum; ++i) {
        const NoiseField noise(0.02, i);
        const Eigen::Vector3d place(0.31 + 1e-3 * (i % 37), -0.7, 0.013 * (i % 11));
        const double here = noise.at(place);
        square += here * here / kNum;
        product += here * noise.at(place + Eigen::Vector3d(0.02, 0.0, 0.0)) / kNum;
    }
    EXPECT_NEAR(square, 1.0, 0.03);
    EXPECT_NEAR(product, std::exp(-1.0), 0.03);
}

}  // namespace
}  // namespace divemesh::reef
