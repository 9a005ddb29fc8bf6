#include "worker/io/trajectory_file.hpp"

#include "tests/worker/io/test_files.hpp"

namespace divemesh::io {
namespace {

class TrajectoryFileTest : public FileTest {};

types::Trajectory turning_path() {
    types::Trajectory trajectory;
    for (int i = 0; i < 5; ++i) {
        Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
        pose.rotate(Eigen::AngleAxisd(0.3 * i, Eigen::Vector3d(1, 2, 3).normalized()));
        pose.translation() = Eigen::Vector3d(0.1 * i, -0.2 * i, 1.0 / 3.0);
        trajectory.push_back({1'403'636'579'763'555'584 + i * 50'000'001, pose});
    }
    return trajectory;
}

TEST_F(TrajectoryFileTest, ATumFileKeepsNanosecondsAndPoses) {
    const types::Trajectory written = turning_path();
    write_tum(file("t.tum"), written);
    const TrajectoryFile result = read_trajectory(file("t.tum"));
    EXPECT_EQ(result.format, TrajectoryFormat::Tum);
    ASSERT_EQ(result.poses.size(), written.size());
    for (std::size_t i = 0; i < written.size(); ++i) {
        EXPECT_EQ(result.poses[i].timestamp_ns, written[i].timestamp_ns);
        EXPECT_TRUE(result.poses[i].T_world_imu.isApprox(written[i].T_world_imu, 1e-8));
    }
}

TEST_F(TrajectoryFileTest, TumQuaternionsEndWithW) {
    const auto path = write("t.tum", "# comment\n1.5 1 2 3 0 0 0.70710678 0.70710678\n");
    const types::StampedPose pose = read_trajectory(path).poses.at(0);
    EXPECT_EQ(pose.timestamp_ns, 1'500'000'000);
    const Eigen::Vector3d turned = pose.T_world_imu.linear() * Eigen::Vector3d::UnitX();
    EXPECT_LT((turned - Eigen::Vector3d::UnitY()).norm(), 1e-7);
}

TEST_F(TrajectoryFileTest, EurocQuaternionsStartWithW) {
    const auto path = write("data.csv",
                            "#timestamp, p_RS_R_x [m], ...\n"
                            "1403636579758555392,1,2,3,0.70710678,0,0,0.70710678,9,9,9\n");
    const TrajectoryFile result = read_trajectory(path);
    EXPECT_EQ(result.format, TrajectoryFormat::Euroc);
    EXPECT_EQ(result.poses.at(0).timestamp_ns, 1403636579758555392);
    const Eigen::Vector3d turned = result.poses[0].T_world_imu.linear() * Eigen::Vector3d::UnitX();
    EXPECT_LT((turned - Eigen::Vector3d::UnitY()).norm(), 1e-7);
}

TEST_F(TrajectoryFileTest, KittiLinesAreNumberedMatrices) {
    const auto path = write("00.txt", "1 0 0 1 0 1 0 2 0 0 1 3\n0 -1 0 4 1 0 0 5 0 0 1 6\n");
    const TrajectoryFile result = read_trajectory(path);
    EXPECT_EQ(result.format, TrajectoryFormat::Kitti);
    ASSERT_EQ(result.poses.size(), 2U);
    EXPECT_EQ(result.poses[1].timestamp_ns, 1);
    EXPECT_EQ(result.poses[1].T_world_imu * Eigen::Vector3d::UnitX(), Eigen::Vector3d(4, 6, 6));
}

TEST_F(TrajectoryFileTest, MistakesAreToldWithTheirLine) {
    const std::string good = "1.0 0 0 0 0 0 0 1\n";
    for (const std::string& bad : {std::string("2.0 0 0 zero 0 0 0 1\n"),
                                   std::string("2.0 0 0 nan 0 0 0 1\n"),
                                   std::string("2.0 0 0 0 0 0 0 0\n"),
                                   std::string("2.0 0 0 0\n"),
                                   std::string("x 0 0 0 0 0 0 1\n"),
                                   std::string("1403636579758555392 0 0 0 0 0 0 1\n"),
                                   std::string("1.0 0 0 0 0 0 0 1\n"),
                                   std::string("0.5 0 0 0 0 0 0 1\n")}) {
        const auto path = write("t.tum", good + bad);
        const Error error = error_of([&] { read_trajectory(path); });
        EXPECT_EQ(error.code(), ErrorCode::BadData);
        EXPECT_EQ(std::string(error.what()).rfind("t.tum:2: ", 0), 0U) << error.what();
    }
}

TEST_F(TrajectoryFileTest, AMirroredKittiMatrixIsRefused) {
    const auto path = write("00.txt", "-1 0 0 1 0 1 0 2 0 0 1 3\n");
    EXPECT_EQ(error_of([&] { read_trajectory(path); }).code(), ErrorCode::BadData);
}

TEST_F(TrajectoryFileTest, NoPoseAtAllIsAnError) {
    const auto path = write("t.tum", "# nothing\n");
    EXPECT_EQ(error_of([&] { read_trajectory(path); }).code(), ErrorCode::BadData);
    EXPECT_EQ(error_of([&] { read_trajectory(file("absent")); }).code(), ErrorCode::NotFound);
}

}  // namespace
}  // namespace divemesh::io
