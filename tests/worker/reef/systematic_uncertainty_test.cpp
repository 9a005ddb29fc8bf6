#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <string>

#include "tests/worker/reef/sheets.hpp"
#include "worker/reef/area_plane.hpp"
#include "worker/reef/measure_areas.hpp"
#include "worker/reef/measure_outline.hpp"
#include "worker/reef/surface_noise.hpp"
#include "worker/reef/surface_patch.hpp"

namespace divemesh::reef {
namespace {

using nlohmann::json;

constexpr double kSigma_m = 0.001;
constexpr double kDetail_m = 0.0125;

double hills(double x, double y) {
    return 0.1 * x + 0.0075 * std::sin(36.0 * x) * std::cos(28.0 * y);
}

// Returns hills whose vertices have errors like those of a bent model: correlated over the detail.
types::Mesh bent_hills(std::uint64_t seed) {
    types::Mesh mesh = sheet(0.16, 0.0025, hills);
    mesh.sigma_m.assign(mesh.vertices.size(), static_cast<float>(kSigma_m));
    mesh.sigma_local_m.assign(mesh.vertices.size(), 1e-6F);
    const NoiseField field(kDetail_m, seed);
    for (Eigen::Vector3f& vertex : mesh.vertices)
        vertex.z() += static_cast<float>(kSigma_m * field.at(vertex.cast<double>()));
    return mesh;
}

json flatten_metrics(const types::Mesh& mesh, const MeasureOptions& options) {
    const AreaPlane plane = plane_of(quadrat("q", 0.02, 0.14));
    return {{"figures", measure_outline(mesh, {"q", "", "quadrat"}, plane, options).metrics}};
}

TEST(SystematicUncertainty, OfBendsHoldTheTruthInNinetyFiveOfAHundredSurfaces) {
    MeasureOptions options;
    options.num_replicates = 16;
    options.scale_sigma = 0.0;
    options.spacings_m = {0.02};
    const json truth = flatten_metrics(sheet(0.16, 0.0025, hills), options);
    options.min_detail_m = kDetail_m;
    constexpr int kNumSeeds = 50;
    std::map<std::string, int> num_held{{"volume", 0}, {"slope", 0}, {"aspect", 0}};
    for (int seed = 1; seed <= kNumSeeds; ++seed) {
        const json measured = flatten_metrics(bent_hills(seed), options);
        for (auto& [metric, num] : num_held) {
            const double exact = metric_of(truth, "q", metric)["value"];
            const json entry = metric_of(measured, "q", metric);
            num += entry["low"].get<double>() <= exact && exact <= entry["high"].get<double>();
        }
    }
    int num_missed = 0;
    for (const auto& [metric, num] : num_held) {
        EXPECT_GE(num, 0.86 * kNumSeeds) << metric;
        num_missed += kNumSeeds - num;
    }
    EXPECT_GT(num_missed, 0);  // the intervals are not simply too wide
}

TEST(SystematicUncertainty, WhereAStepLiesCountsForItsVolume) {
    const auto wall = [](double x, double) { return x < 0.305 ? 0.5 : 0.0; };
    const AreaSet set{AreaFrame::World, {quadrat("q", 0.0, 0.6)}};
    MeasureOptions options;
    options.num_replicates = 8;
    options.scale_sigma = 0.0;
    options.min_detail_m =
        0.03465;  // a standard deviation of 20 mm over 60 cm of a wall 50 cm high
    const json volume =
        metric_of(measure_areas(sheet(0.6, 0.01, wall), set, options), "q", "volume");
    const double half_width = 0.5 * (volume["high"].get<double>() - volume["low"].get<double>());
    EXPECT_NEAR(half_width, 1.96 * 0.02 * 0.6 * 0.5, 0.1 * half_width);
}

}  // namespace
}  // namespace divemesh::reef
