#include <gtest/gtest.h>

#include <fstream>

#include "schemas/error.hpp"
#include "tests/temporary_folder.hpp"
#include "tests/worker/recording/bag_writer.hpp"
#include "tests/worker/recording/message_writer.hpp"
#include "worker/dive/calibration.hpp"
#include "worker/recording/import_recording.hpp"

namespace divemesh::recording {
namespace {

namespace fs = std::filesystem;

// A robot whose IMU and cameras are on links of a base. Optical frames look along x of their link.
class Robot {
public:
    std::string recorded(Wire wire) const {
        if (wire == Wire::Ros1) return written(BagWriter(), wire);
        return written(McapBytes("zstd"), wire);
    }
    // Where the right camera is in the left one, by its frames.
    Eigen::Isometry3d T_cam0_cam1() const {
        Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
        T.linear() = Eigen::AngleAxisd(turn_rad, Eigen::Vector3d::UnitY()).toRotationMatrix();
        T.translation() = Eigen::Vector3d(baseline_of_frames_m, 0, 0);
        return T;
    }
    // The base's coordinates of the left camera: x to the right is -y, z ahead is x.
    Eigen::Isometry3d T_imu_cam0() const {
        Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
        T.linear() << 0, 0, 1, -1, 0, 0, 0, -1, 0;
        T.translation() = Eigen::Vector3d(0.3, 0.05, -0.1);
        return T;
    }

    std::string image = "image_raw";
    std::string right_frame = "right_optical";
    std::string imu_frame = "imu_link";
    double baseline_m = 0.12;  // of CameraInfo
    double baseline_of_frames_m = 0.12;
    double turn_rad = 0.0;
    Eigen::Matrix3d R_rect_cam0 = Eigen::Matrix3d::Identity();
    Eigen::Matrix3d R_rect_cam1 = Eigen::Matrix3d::Identity();

private:
    std::vector<TestTransform> transforms() const {
        const Eigen::Quaterniond q(T_cam0_cam1().linear());
        return {{"base", "imu_link", {0, 0, 0.4}, {0, 0, 0, 1}},
                {"base", "left_link", {0.3, 0.05, 0.3}, {0, 0, 0, 1}},
                {"left_link", "left_optical", {0, 0, 0}, {-0.5, 0.5, -0.5, 0.5}},
                {"left_optical",
                 "right_optical",
                 {baseline_of_frames_m, 0, 0},
                 {q.x(), q.y(), q.z(), q.w()}}};
    }

    static std::string info(Wire wire, const Eigen::Matrix3d& R_rect_cam, double shift_m) {
        const Eigen::Matrix3d by_rows = R_rect_cam.transpose();
        return camera_info_message(
            wire,
            64,
            48,
            "plumb_bob",
            {-0.1, 0.01, 0.001, -0.002, 0.0},
            {std::vector<double>{60, 0, 31, 0, 61, 24, 0, 0, 1},
             std::vector<double>(by_rows.data(), by_rows.data() + 9),
             std::vector<double>{55, 0, 30, -55 * shift_m, 0, 55, 23, 0, 0, 0, 1, 0}});
    }

    template <typename Writer>
    std::string written(Writer writer, Wire wire) const {
        const auto add_topic = [&](std::uint16_t number,
                                   const std::string& name,
                                   const std::string& package,
                                   const std::string& type) {
            if constexpr (std::is_same_v<Writer, BagWriter>)
                writer.add_connection(number, name, package + "/" + type);
            else
                writer.add_channel(number, name, package + "/msg/" + type, "cdr");
        };
        add_topic(1, "/left/" + image, "sensor_msgs", "Image");
        add_topic(2, "/right/" + image, "sensor_msgs", "Image");
        add_topic(3, "/left/camera_info", "sensor_msgs", "CameraInfo");
        add_topic(4, "/right/camera_info", "sensor_msgs", "CameraInfo");
        add_topic(5, "/imu", "sensor_msgs", "Imu");
        add_topic(6, "/tf_static", "tf2_msgs", "TFMessage");
        const std::string pixels(64 * 48, 'x');
        writer.add_message(3, 1, info(wire, R_rect_cam0, 0.0));
        writer.add_message(4, 2, info(wire, R_rect_cam1, baseline_m));
        writer.add_message(5, 3, imu_message(wire, 3, {0, 0, 0}, {0, 0, 9.8}, imu_frame));
        writer.add_message(1, 4, image_message(wire, 5, "mono8", 64, 48, pixels, "left_optical"));
        writer.add_message(2, 5, image_message(wire, 5, "mono8", 64, 48, pixels, right_frame));
        writer.add_message(6, 6, transforms_message(wire, transforms()));
        return writer.finished();
    }
};

class ImportFramesTest : public testing::Test {
protected:
    // Imports a robot's recording; returns the calibration that the dive has.
    RigFiles imported(const Robot& robot, Wire wire = Wire::Ros1) {
        ImportOptions options;
        options.recording = folder_ / "recording";
        options.out = folder_ / ("dive" + std::to_string(++num_dives_));
        std::ofstream(options.recording, std::ios::binary) << robot.recorded(wire);
        RecordingImport import(options, base::ignore_progress);
        const ImportCounts counts = import.write(base::ignore_progress);
        findings_ = import.findings();
        EXPECT_EQ(fs::exists(options.out / "mav0" / "imu0"), counts.num_imu > 0);
        dive::FindingLog ignored;
        return rig_of_folder(options.out, ignored);
    }
    const Finding* finding(const std::string& code) const {
        for (const Finding& one : findings_)
            if (one.code == code) return &one;
        return nullptr;
    }

    TemporaryFolder folder_;
    int num_dives_ = 0;
    std::vector<Finding> findings_;
};

TEST_F(ImportFramesTest, TheImuIsUsedWhereTheFramesSayWhereItIs) {
    for (const Wire wire : {Wire::Ros1, Wire::LittleCdr, Wire::BigCdr}) {
        const Robot robot;
        const RigFiles rig = imported(robot, wire);
        EXPECT_TRUE(findings_.empty());
        ASSERT_TRUE(rig.imu_yaml);
        EXPECT_TRUE(rig.cam0.T_body_cam.isApprox(robot.T_imu_cam0(), 1e-12));
        EXPECT_TRUE(rig.cam1.T_body_cam.isApprox(robot.T_imu_cam0() * robot.T_cam0_cam1(), 1e-12));
        dive::FindingLog findings;
        const auto yaml = dive::parse_sensor_yaml(*rig.imu_yaml, "imu0", findings);
        EXPECT_TRUE(
            dive::rigid_motion(*yaml, "imu0", findings)->isApprox(Eigen::Isometry3d::Identity()));
        dive::imu_noise(*yaml, "imu0", findings);
        ASSERT_EQ(findings.all().size(), 1U);
        EXPECT_EQ(findings.all().front().code, "imu_noise_assumed");
    }
}

// A point that the left camera sees, moved by hand: rectified frames are turned, at one place.
TEST_F(ImportFramesTest, TheFrameOfRectifiedImagesIsTurnedFromTheCameras) {
    Robot robot;
    robot.image = "image_rect";
    robot.R_rect_cam0 = Eigen::AngleAxisd(0.02, Eigen::Vector3d::UnitZ()).toRotationMatrix();
    robot.R_rect_cam1 = robot.R_rect_cam0;
    robot.right_frame = "left_optical";
    const RigFiles rig = imported(robot);
    EXPECT_TRUE(findings_.empty());
    const Eigen::Vector3d p_cam0(0.2, -0.3, 1.5);
    EXPECT_LT(
        (rig.cam0.T_body_cam * (robot.R_rect_cam0 * p_cam0) - robot.T_imu_cam0() * p_cam0).norm(),
        1e-12);
}

TEST_F(ImportFramesTest, TheStereoPoseIsThatOfTheFramesWhereCameraInfoHasNone) {
    for (const char* image : {"image_raw", "image_rect"}) {
        Robot robot;
        robot.image = image;
        robot.baseline_m = 0.0;
        robot.turn_rad = 0.05;
        const RigFiles rig = imported(robot);
        const Eigen::Isometry3d T_cam0_cam1 = rig.cam0.T_body_cam.inverse() * rig.cam1.T_body_cam;
        EXPECT_TRUE(T_cam0_cam1.isApprox(robot.T_cam0_cam1(), 1e-12)) << image;
    }
    Robot without;
    without.baseline_m = 0.0;
    without.right_frame = "left_optical";
    EXPECT_THROW(imported(without), Error);
}

TEST_F(ImportFramesTest, FramesThatContradictCameraInfoAreSaidWithBothNumbersAndNotUsed) {
    for (const auto& [baseline_m, turn_rad] :
         std::vector<std::pair<double, double>>{{0.1214, 0.0}, {0.12, 0.018}}) {
        Robot robot;
        robot.baseline_of_frames_m = baseline_m;
        robot.turn_rad = turn_rad;
        const RigFiles rig = imported(robot);
        const Finding* found = finding("transform_contradicts_camera_info");
        ASSERT_TRUE(found);
        EXPECT_NE(found->message.find("0.12 m"), std::string::npos) << found->message;
        EXPECT_NE(found->message.find(turn_rad > 0.0 ? "1.03 degrees" : "0.1214 m"),
                  std::string::npos)
            << found->message;
        EXPECT_FALSE(rig.imu_yaml);
        EXPECT_TRUE(finding("imu_left_out"));
        EXPECT_NEAR(
            (rig.cam0.T_body_cam.inverse() * rig.cam1.T_body_cam).translation().x(), 0.12, 1e-12);
    }
    Robot close;
    close.baseline_of_frames_m = 0.1211;
    close.turn_rad = 0.016;
    EXPECT_TRUE(imported(close).imu_yaml);
    EXPECT_TRUE(findings_.empty());
}

TEST_F(ImportFramesTest, AnImuWhoseFrameIsNotRelatedIsLeftOut) {
    Robot robot;
    robot.imu_frame = "unknown";
    EXPECT_FALSE(imported(robot).imu_yaml);
    ASSERT_TRUE(finding("frames_unrelated"));
    EXPECT_NE(finding("frames_unrelated")->message.find("'unknown'"), std::string::npos);
    EXPECT_TRUE(finding("imu_left_out"));
}

}  // namespace
}  // namespace divemesh::recording
