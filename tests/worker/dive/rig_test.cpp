#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>

#include "tests/temporary_folder.hpp"
#include "tests/worker/dive/tiny_dive.hpp"
#include "worker/dive/dive.hpp"

namespace divemesh::dive {
namespace {

// The body is a separate frame: IMU and cameras are mounted on it, and ground truth is that of the
// body.
TEST(RigTest, AnImuThatIsNotTheBodyBecomesTheFrameOfEverything) {
    const TemporaryFolder folder;
    const TinyDive tiny(folder / "dive");
    tiny.write("mav0/imu0/sensor.yaml",
               "T_BS: [0,-1,0,1, 1,0,0,2, 0,0,1,3, 0,0,0,1]\ngyroscope_noise_density: 0.004\n");

    const auto dive = Dive::open(tiny.folder(), folder / "scratch");

    // cam0 is at the body's origin; the IMU is at (1, 2, 3), rotated by 90 degrees about z.
    const Eigen::Isometry3d& T_imu_cam0 = dive->rig().T_imu_cam0;
    EXPECT_LT((T_imu_cam0.translation() - Eigen::Vector3d(-2, 1, -3)).norm(), 1e-9);
    EXPECT_NEAR(dive->rig().baseline_m(), 0.1, 1e-12);
    const Eigen::Isometry3d& T_world_imu = dive->ground_truth()[1].T_world_imu;
    EXPECT_LT((T_world_imu.translation() - Eigen::Vector3d(1, 2, 3)).norm(), 1e-9);
    EXPECT_LT((T_world_imu.linear() * Eigen::Vector3d::UnitX() - Eigen::Vector3d::UnitY()).norm(),
              1e-9);
    EXPECT_DOUBLE_EQ(dive->rig().imu_noise->gyroscope_noise_density, 0.004);
}

TEST(RigTest, WithoutAnImuTheBodyIsCam0) {
    const TemporaryFolder folder;
    const TinyDive tiny(folder / "dive");
    tiny.remove("mav0/imu0");
    tiny.write("mav0/cam0/sensor.yaml", camera_yaml("1,0,0,0.5, 0,1,0,0, 0,0,1,0, 0,0,0,1"));
    tiny.write("mav0/cam1/sensor.yaml", camera_yaml("1,0,0,0.6, 0,1,0,0, 0,0,1,0, 0,0,0,1"));
    tiny.write("mav0/ahrs0/data.csv", "1600000000000000000,1,0,0,0\n1600000000400000000,0,0,0,1\n");

    const auto dive = Dive::open(tiny.folder(), folder / "scratch");

    EXPECT_TRUE(dive->rig().T_imu_cam0.isApprox(Eigen::Isometry3d::Identity()));
    EXPECT_FALSE(dive->rig().imu_noise.has_value());
    ASSERT_EQ(dive->ahrs().size(), 2U);
    EXPECT_NEAR(dive->ahrs()[1].q_world_imu.z(), 1.0, 1e-12);
    EXPECT_NEAR(dive->ground_truth()[1].T_world_imu.translation().x(), 0.5, 1e-9);
}

TEST(RigTest, MarkersAreReadOrRefuseTheDiveByTheField) {
    const TemporaryFolder folder;
    const TinyDive tiny(folder / "dive");
    tiny.write("markers.json", R"({"family": "tag25h9", "size_m": 0.1})");
    const auto good = Dive::open(tiny.folder(), folder / "scratch");
    tiny.write("markers.json", R"({"family": "tag25h9", "size_m": "large"})");
    const auto bad = Dive::open(tiny.folder(), folder / "scratch");

    EXPECT_TRUE(good->markers());
    EXPECT_EQ(good->markers()->size_m, 0.1);
    EXPECT_FALSE(bad->markers());
    const auto refusal =
        std::find_if(bad->findings().begin(), bad->findings().end(), [](const Finding& finding) {
            return finding.code == "markers_unreadable";
        });
    ASSERT_NE(refusal, bad->findings().end());
    EXPECT_EQ(refusal->severity, Severity::Error);
    EXPECT_NE(refusal->message.find("field size_m must be"), std::string::npos);
}

TEST(RigTest, MeasurementsReferenceMeshAndWaterAreRead) {
    const TemporaryFolder folder;
    const TinyDive tiny(folder / "dive");
    tiny.write("dive.json", R"({"name": "A", "water": {"temperature": 4, "salinity": 35}})");
    tiny.write("measurements.json",
               R"({"distances": [{"name": "bar", "a": [0,0,0], "b": [3,4,0], "distance_m": 5}]})");
    const std::string triangle =
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
        "property float z\nelement face 1\nproperty list uchar int vertex_indices\n"
        "end_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
    tiny.write("reference.ply", triangle);
    tiny.write("scene.ply", triangle);

    const auto dive = Dive::open(tiny.folder(), folder / "scratch");

    EXPECT_EQ(dive->info().water_temperature_c, 4.0);
    EXPECT_EQ(dive->info().water_salinity_psu, 35.0);
    ASSERT_EQ(dive->known_distances().size(), 1U);
    EXPECT_EQ(dive->known_distances()[0].b_world, Eigen::Vector3d(3, 4, 0));
    EXPECT_EQ(dive->read_reference_mesh()->triangles.size(), 1U);
    EXPECT_EQ(dive->read_scene_mesh()->triangles.size(), 1U);
}

TEST(MeasurementsTest, EndsMarkedInImages) {
    const TemporaryFolder folder;
    const TinyDive tiny(folder / "dive");
    tiny.write("measurements.json", R"({"distances": [
        {"name": "bar", "distance_m": 1,
         "marks_a": [{"timestamp_ns": 7, "left": [1.5, 2], "right": [0.5, 2]}],
         "marks_b": [{"timestamp_ns": 7, "left": [9, 8]}]},
        {"name": "one end", "distance_m": 1, "marks_a": [{"timestamp_ns": 7, "left": [1, 2]}]},
        {"name": "text", "distance_m": 1, "marks_a": [{"timestamp_ns": 7, "left": ["1", 2]}],
         "marks_b": [{"timestamp_ns": 7, "left": [9, 8]}]}]})");

    const auto dive = Dive::open(tiny.folder(), folder / "scratch");

    ASSERT_EQ(dive->known_distances().size(), 1U);
    const KnownDistance& bar = dive->known_distances()[0];
    EXPECT_EQ(bar.marks_a.at(0).timestamp_ns, 7);
    EXPECT_EQ(bar.marks_a.at(0).pixel_right, Eigen::Vector2d(0.5, 2.0));
    EXPECT_EQ(bar.marks_b.at(0).pixel_left, Eigen::Vector2d(9.0, 8.0));
    EXPECT_FALSE(bar.marks_b.at(0).pixel_right.has_value());
    EXPECT_EQ(std::count_if(dive->findings().begin(),
                            dive->findings().end(),
                            [](const Finding& f) { return f.code == "measurement_incomplete"; }),
              2);
}

}  // namespace
}  // namespace divemesh::dive
