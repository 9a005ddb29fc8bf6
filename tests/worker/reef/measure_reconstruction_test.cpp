#include "worker/reef/measure_reconstruction.hpp"

#include <gtest/gtest.h>

#include <fstream>

#include "tests/temporary_folder.hpp"
#include "tests/worker/reef/sheets.hpp"
#include "worker/io/ply.hpp"
#include "worker/io/trajectory_file.hpp"

namespace divemesh::reef {
namespace {

using nlohmann::json;

// A result of level ground, 1 m x 1 m, that a rig saw from 2 m above its middle.
class MeasureReconstructionTest : public testing::Test {
protected:
    MeasureReconstructionTest() {
        types::Trajectory trajectory(1);
        trajectory[0].T_world_imu.translation() = Eigen::Vector3d(0.5, 0.5, 2.0);
        io::write_tum(folder_ / "trajectory.tum", trajectory);
        write("areas.json", R"({"areas": [{"name": "q", "corners": [[0.2, 0.2, 0], [0.8, 0.2, 0],
                                           [0.8, 0.8, 0], [0.2, 0.8, 0]]}]})");
        write("metrics.json", "{}");
        give_ground(0.01);
    }

    void write(const std::string& name, const std::string& text) const {
        std::ofstream(folder_ / name) << text;
    }
    void give_ground(double cell_m) const {
        types::Mesh mesh = sheet(1.0, cell_m, [](double, double) { return 0.0; });
        mesh.sigma_m.assign(mesh.vertices.size(), 0.002F);
        io::write_ply(folder_ / "mesh.ply", mesh);
    }
    json measure() const {
        return measure_reconstruction({folder_.path(), folder_ / "areas.json", std::nullopt});
    }

private:
    TemporaryFolder folder_;
};

TEST_F(MeasureReconstructionTest, DetailIsThatOfTheImagesInWhichTheSurfaceWasMatched) {
    write("metrics.json",
          R"({"calibration": {"focal_px": [900, 900]}, "frames": {"reduction": 2}})");
    write("keyframes.json", R"({"focal_px": 300, "keyframes": []})");
    const json measured = measure();
    const double range_m = 2.02;  // the median over the quadrat
    EXPECT_NEAR(measured["areas"][1]["detail_m"].get<double>(), 15.0 * range_m / 300.0, 1e-3);
    EXPECT_TRUE(metric_of(measured, "q", "rugosity", 0.10).contains("refused"));
    EXPECT_TRUE(metric_of(measured, "q", "rugosity", 0.25).contains("value"));
}

}  // namespace
}  // namespace divemesh::reef
