#include "worker/reef/measure_reconstruction.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "tests/temporary_folder.hpp"
#include "tests/worker/reef/sheets.hpp"
#include "worker/evaluation/scaled_uncertainty.hpp"
#include "worker/io/ply.hpp"
#include "worker/io/trajectory_file.hpp"

namespace divemesh::reef {
namespace {

using nlohmann::json;

constexpr double kSide_m = 0.5;
constexpr float kSigma_m = 0.002F;

// A reconstruction of a flat square, 2 m below the path.
class MeasureReconstructionTest : public testing::Test {
protected:
    MeasureReconstructionTest() {
        mesh_ = sheet(kSide_m, 0.01, [](double, double) { return -2.0; });
        mesh_.sigma_m.assign(mesh_.vertices.size(), kSigma_m);
        mesh_.sigma_local_m.assign(mesh_.vertices.size(), 0.5F * kSigma_m);
        mesh_.normals.assign(mesh_.vertices.size(), Eigen::Vector3f::UnitZ());
        for (const double x : {0.0, 0.25, 0.5})
            path_.push_back(
                {std::llround(1e9 * x), Eigen::Isometry3d(Eigen::Translation3d(x, 0.25, 0.0))});
        io::write_tum(folder_ / "trajectory.tum", path_);
        std::ofstream(folder_ / "areas.json")
            << R"({"frame": "world", "areas": [{"name": "q", "kind": "quadrat",
                   "corners": [[0.1, 0.1, -2], [0.4, 0.1, -2], [0.4, 0.4, -2], [0.1, 0.4, -2]]}]})";
    }
    json measured(const json& calibration) {
        std::ofstream(folder_ / "metrics.json") << json{{"calibration", calibration}};
        io::write_ply(folder_ / "mesh.ply", mesh_);
        return measure_reconstruction({folder_.path(), folder_ / "areas.json", std::nullopt, 1});
    }
    static json metric_of(const json& measured, const std::string& metric) {
        for (const json& entry : measured.at("figures"))
            if (entry.at("figure") == metric && entry.at("area") == "q") return entry;
        ADD_FAILURE() << "no " << metric;
        return json();
    }

    TemporaryFolder folder_;
    types::Mesh mesh_;
    types::Trajectory path_;
};

TEST_F(MeasureReconstructionTest, IntervalsContainTheScaleThatTheReconstructionStates) {
    const json area = metric_of(measured({{"scale_sigma", 0.004}}), "planar_area");
    EXPECT_NEAR(area["value"].get<double>(), 0.09, 1e-6);
    EXPECT_NEAR(area["high"].get<double>() - area["low"].get<double>(),
                2.0 * 1.96 * 2.0 * 0.004 * 0.09,
                1e-6);
}

// Another measurement says that all lengths are 5 % longer.
TEST_F(MeasureReconstructionTest, AScaleThatContradictsIsInSizesButRoughensNothing) {
    constexpr double kContradiction = 0.05;
    const double sigma = evaluation::contradiction_sigma(kContradiction);
    mesh_ = evaluation::with_scale_sigma(std::move(mesh_), path_, 0.0, sigma);
    EXPECT_GT(mesh_.sigma_m[0], 0.05F);
    const json result = measured(
        {{"scale_sigma", std::hypot(0.002, sigma)}, {"scale_contradiction", kContradiction}});
    const json diameter = metric_of(result, "longest_diameter");
    const double value_m = diameter["value"].get<double>();
    EXPECT_GT(diameter["high"].get<double>(), (1.0 + kContradiction) * value_m);
    EXPECT_LT(diameter["low"].get<double>(), (1.0 - kContradiction) * value_m);
    EXPECT_NEAR(result["areas"][1]["sigma_m"].get<double>(), kSigma_m, 1e-5);
}

}  // namespace
}  // namespace divemesh::reef
