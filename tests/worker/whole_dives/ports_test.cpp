#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <nlohmann/json.hpp>
#include <vector>

#include "tests/temporary_folder.hpp"
#include "worker/io/reconstruction_folder.hpp"
#include "worker/pipeline/reconstruct_dive.hpp"
#include "worker/simulator/simulate.hpp"
#include "worker/stats/median.hpp"

namespace divemesh::pipeline {
namespace {

// The result of a dive over a plane through flat ports, 3 cm before the lenses.
struct Result {
    nlohmann::json metrics;
    types::Mesh mesh;
};

Result reconstructed(bool described, const nlohmann::json& options) {
    const TemporaryFolder folder;
    simulator::simulate(
        {.scene = simulator::SceneKind::Bed,
         .out = folder / "dive",
         .length_m = 3.0,
         .rate_hz = 6.0,
         .water = simulator::WaterKind::Clear,
         .width_px = 400,
         .height_px = 300,
         .ports = simulator::SimulatedPorts{.distance_m = 0.03, .described = described}});
    Result result;
    result.metrics = reconstruct_dive({.dive = folder / "dive",
                                       .out = folder / "out",
                                       .scratch = folder / "scratch",
                                       .resumable = false,
                                       .options = make_options("standard", options)},
                                      base::ignore_progress);
    if (result.metrics.contains("mesh"))
        result.mesh = io::ReconstructionFolder(folder / "out").mesh();
    return result;
}

bool has_finding(const nlohmann::json& metrics, const std::string& code) {
    return std::any_of(metrics["findings"].begin(),
                       metrics["findings"].end(),
                       [&](const auto& finding) { return finding["code"] == code; });
}

// Returns the median distance of the vertices to the plane z = height that fits them best, m.
double off_plane_m(const types::Mesh& mesh) {
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    for (const Eigen::Vector3f& p : mesh.vertices)
        mean += p.cast<double>() / static_cast<double>(mesh.vertices.size());
    Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
    for (const Eigen::Vector3f& p : mesh.vertices) {
        const Eigen::Vector3d d = p.cast<double>() - mean;
        scatter += d * d.transpose();
    }
    const Eigen::Vector3d normal =
        Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(scatter).eigenvectors().col(0);
    std::vector<double> off_m;
    for (const Eigen::Vector3f& p : mesh.vertices)
        off_m.push_back(std::abs(normal.dot(p.cast<double>() - mean)));
    return stats::median(std::move(off_m));
}

TEST(PortsOfADiveTest, APlaneBehindDescribedPortsIsFlatAndItsPathIsRight) {
    const Result result = reconstructed(true, {{"texture", false}});

    EXPECT_EQ(result.metrics["frames"]["coverage"].get<double>(), 1.0);
    EXPECT_LT(result.metrics["trajectory"]["final"]["ate_rmse_m"].get<double>(), 0.003);
    EXPECT_NEAR(result.metrics["trajectory"]["final"]["sim3_scale"].get<double>(), 1.0, 0.002);
    EXPECT_FALSE(has_finding(result.metrics, "calibration_medium"));
    EXPECT_LT(off_plane_m(result.mesh), 0.002);
    const auto& port = result.metrics["calibration"]["rig"]["cam0"]["port"];
    EXPECT_EQ(port["distance_m"].get<double>(), 0.03);
    EXPECT_NEAR(port["reference_depth_m"].get<double>(), 1.2, 0.3);
}

TEST(PortsOfADiveTest, GlassThatIsNotDescribedIsNoticed) {
    const Result result = reconstructed(false, {{"surface", false}});

    EXPECT_TRUE(has_finding(result.metrics, "calibration_medium"));
}

}  // namespace
}  // namespace divemesh::pipeline
