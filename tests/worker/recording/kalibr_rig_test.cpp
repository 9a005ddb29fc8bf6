#include "tests/worker/recording/calibration_files.hpp"
#include "worker/recording/imu_clock.hpp"

namespace divemesh::recording {
namespace {

class KalibrRigTest : public CalibrationFilesTest {};

TEST_F(KalibrRigTest, AChainOfKalibrWithoutAnImuHasTheLeftCameraAsItsBody) {
    const RigFiles rig = read({file("a.txt", camchain())});
    expect_true_rig(rig);
    EXPECT_TRUE(rig.cam0.T_body_cam.isApprox(Eigen::Isometry3d::Identity()));
    EXPECT_FALSE(rig.imu_yaml);
}

TEST_F(KalibrRigTest, AChainOfKalibrWithAnImuGivesTheInverseOfTCamImu) {
    const std::string imu =
        "accelerometer_noise_density: 0.0021\naccelerometer_random_walk: 3.0e-05\n"
        "gyroscope_noise_density: 0.00017\ngyroscope_random_walk: 1.9e-05\n"
        "rostopic: /imu0\nupdate_rate: 200.0\n";
    const RigFiles rig = read({file("camchain-imucam.yaml", camchain_imucam()), file("i", imu)});
    expect_true_rig(rig);
    expect_true_mounting(rig);
    EXPECT_FALSE(has_code("imu_noise_assumed"));
    const auto yaml = dive::parse_sensor_yaml(rig.imu_yaml.value(), "imu", findings_).value();
    EXPECT_EQ(yaml.gyroscope_noise_density, 0.00017);
    EXPECT_EQ(yaml.gyroscope_random_walk, 1.9e-05);
    EXPECT_EQ(yaml.accelerometer_noise_density, 0.0021);
    EXPECT_EQ(yaml.accelerometer_random_walk, 3.0e-05);
    EXPECT_TRUE(yaml.T_body_sensor->isIdentity());
}

TEST_F(KalibrRigTest, TheClockOfTheImuIsThatOfTheLeftCamera) {
    const RigFiles rig = read({file("camchain-imucam.yaml", camchain_imucam())});
    ASSERT_TRUE(rig.imu_shift);
    EXPECT_EQ(rig.imu_shift->shift_s, -0.004);
    EXPECT_FALSE(has_code("calibration_time_offset"));
    report_unapplied_shift(rig, findings_);
    EXPECT_TRUE(has_code("calibration_time_offset"));
    EXPECT_FALSE(has_code("calibration_time_offsets_differ"));
    std::string text = camchain_imucam();
    text.replace(text.rfind("-0.004"), 6, "0.0125");
    EXPECT_EQ(read({file("c", text)}).imu_shift->shift_s, -0.004);
    EXPECT_TRUE(has_code("calibration_time_offsets_differ"));
    text.replace(text.find("-0.004"), 6, "1.0e99");
    EXPECT_NE(refusal_of({file("c", text)}).find("timeshift_cam_imu"), std::string::npos);
    EXPECT_FALSE(read({file("c", camchain())}).imu_shift);
}

TEST_F(KalibrRigTest, OneTCamImuAndTheChainGiveTheSameRigAsBoth) {
    const std::string text =
        kalibr_camera("cam0", kalibr_matrix("T_cam_imu", truth_.T_imu_cam0.inverse()), false) +
        kalibr_camera("cam1", kalibr_matrix("T_cn_cnm1", truth_.T_cam0_cam1.inverse()), true);
    expect_true_mounting(read({file("c", text)}));
    // OpenVINS states the poses themselves.
    const std::string poses =
        "%YAML:1.0 # need to specify the file type at the top!\n" +
        kalibr_camera("cam0", kalibr_matrix("T_imu_cam", truth_.T_imu_cam0), false) +
        kalibr_camera("cam1", kalibr_matrix("T_imu_cam", truth_.T_imu_cam1()), true);
    expect_true_mounting(read({file("c", poses)}));
}

TEST_F(KalibrRigTest, CamerasOfAChainAreThoseOfTheTopics) {
    // cam0 is the right camera, cam2 the left one, and another one lies between them.
    const Eigen::Isometry3d T_cam1_cam0 = TrueRig::pose(0.4, {0, 1, 0}, {0, 0.3, 0});
    const Eigen::Isometry3d T_cam2_cam1 = truth_.T_cam0_cam1 * T_cam1_cam0.inverse();
    const std::string text = kalibr_camera("cam0", "", true) +
                             kalibr_camera("cam1", kalibr_matrix("T_cn_cnm1", T_cam1_cam0), true) +
                             kalibr_camera("cam2", kalibr_matrix("T_cn_cnm1", T_cam2_cam1), false);
    hints_.left_topic = "/cam2/image_raw/compressed";
    hints_.right_topic = "/cam0/image_raw";
    expect_true_rig(read({file("c", text)}));
    EXPECT_TRUE(has_code("calibration_sides"));
}

TEST_F(KalibrRigTest, AChainThatContradictsItselfIsRefused) {
    std::string text = camchain_imucam();
    const std::size_t stated = text.rfind("T_cn_cnm1");
    text.replace(text.find("0.", stated), 2, "1.");  // the first entry of its rotation
    EXPECT_NE(refusal_of({file("c", text)}).find("T_cn_cnm1"), std::string::npos);
    const std::string moved =
        kalibr_camera("cam0", kalibr_matrix("T_cam_imu", truth_.T_imu_cam0.inverse()), false) +
        kalibr_camera("cam1",
                      kalibr_matrix("T_cam_imu", truth_.T_imu_cam1().inverse()) +
                          kalibr_matrix("T_cn_cnm1", TrueRig::pose(0, {1, 0, 0}, {-0.1, 0, 0})),
                      true);
    EXPECT_NE(refusal_of({file("c", moved)}).find("contradicts itself"), std::string::npos);
}

TEST_F(KalibrRigTest, ModelsOfKalibrThatAreNotReadAreRefusedWithWhatToDo) {
    std::string fov = camchain();
    fov.replace(fov.find("pinhole"), 7, "sphere");
    EXPECT_NE(refusal_of({file("c", fov)}).find("pinhole-radtan"), std::string::npos);
    std::string too_few = camchain();
    too_few.replace(too_few.find("pinhole"), 7, "ds");
    EXPECT_NE(refusal_of({file("c", too_few)}).find("xi, alpha, fu"), std::string::npos);
    std::string equi = camchain();
    for (std::size_t at = equi.find("radtan"); at != equi.npos; at = equi.find("radtan"))
        equi.replace(at, 6, "equidistant");
    EXPECT_EQ(read({file("c", equi)}).cam1.camera.distortion, types::Distortion::Equidistant);
}

// A chain of Kalibr with both cameras of another model.
TEST_F(KalibrRigTest, OmniDoubleSphereAndExtendedUnifiedAreRead) {
    const auto lens =
        [&](const std::string& model, const std::string& leading, const std::string& distortion) {
            std::string text = camchain();
            const auto replace_all = [&](const std::string& from, const std::string& to) {
                for (std::size_t at = text.find(from); at != text.npos;
                     at = text.find(from, at + to.size()))
                    text.replace(at, from.size(), to);
            };
            replace_all("pinhole", model);
            replace_all("intrinsics: [", "intrinsics: [" + leading);
            if (distortion == "none")
                replace_all("distortion_model: radtan", "distortion_model: none");
            return read({file("c", text)}).cam0.camera;
        };
    const types::Camera ds = lens("ds", "-0.2, 0.6, ", "none");
    EXPECT_EQ(ds.distortion, types::Distortion::DoubleSphere);
    EXPECT_EQ(ds.distortion_coefficients, (types::LensCoefficients{-0.2, 0.6}));
    EXPECT_DOUBLE_EQ(ds.fx_px, 489.6 / 0.8);
    const types::Camera eucm = lens("eucm", "0.6, 1.1, ", "none");
    EXPECT_EQ(eucm.distortion, types::Distortion::ExtendedUnified);
    EXPECT_EQ(eucm.distortion_coefficients, (types::LensCoefficients{0.6, 1.1}));
    EXPECT_EQ(eucm.fx_px, 489.6);
    const types::Camera omni = lens("omni", "1.5, ", "radtan");
    EXPECT_EQ(omni.distortion, types::Distortion::Omnidirectional);
    EXPECT_EQ(omni.distortion_coefficients,
              (types::LensCoefficients{1.5, -0.121, 0.0312, 0.00041, -0.00032}));
    EXPECT_DOUBLE_EQ(omni.fx_px, 489.6 / 2.5);
    EXPECT_EQ(lens("omni", "1.5, ", "none").distortion_coefficients,
              (types::LensCoefficients{1.5}));
}

}  // namespace
}  // namespace divemesh::recording
