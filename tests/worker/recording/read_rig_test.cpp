#include "worker/recording/read_rig.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <fstream>
#include <sstream>

#include "schemas/error.hpp"
#include "tests/temporary_folder.hpp"

namespace divemesh::recording {
namespace {

namespace fs = std::filesystem;

std::string file_text(const fs::path& file) {
    std::ostringstream text;
    text << std::ifstream(file, std::ios::binary).rdbuf();
    return text.str();
}

// The rig that every file of these tests states: its geometry as axes, angles and positions.
struct TrueRig {
    Eigen::Isometry3d T_imu_cam0 = pose(1.2, {1, 2, 3}, {0.05, -0.02, 0.03});
    Eigen::Isometry3d T_cam0_cam1 = pose(0.03, {2, -1, 1}, {0.12, 0.002, -0.003});

    Eigen::Isometry3d T_imu_cam1() const { return T_imu_cam0 * T_cam0_cam1; }

    static Eigen::Isometry3d pose(double angle_rad,
                                  const Eigen::Vector3d& axis,
                                  const Eigen::Vector3d& position_m) {
        Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
        T.linear() = Eigen::AngleAxisd(angle_rad, axis.normalized()).toRotationMatrix();
        T.translation() = position_m;
        return T;
    }
};

// Returns numbers as one text, by rows, with every digit.
template <typename Matrix>
std::string numbers(const Matrix& matrix, const char* separator = ", ", double unit = 1.0) {
    std::ostringstream text;
    text.precision(17);
    for (int row = 0; row < matrix.rows(); ++row)
        for (int column = 0; column < matrix.cols(); ++column)
            text << (row + column > 0 ? separator : "") << matrix(row, column) / unit;
    return text.str();
}

// As PyYAML writes a matrix in Kalibr's files.
std::string kalibr_matrix(const char* key, const Eigen::Isometry3d& T) {
    std::string text = std::string("  ") + key + ":\n";
    for (int row = 0; row < 4; ++row) text += "  - [" + numbers(T.matrix().row(row)) + "]\n";
    return text;
}

// As cv::FileStorage writes a matrix.
std::string opencv_matrix(const char* key, int rows, int cols, const std::string& data) {
    return std::string(key) + ": !!opencv-matrix\n   rows: " + std::to_string(rows) +
           "\n   cols: " + std::to_string(cols) + "\n   dt: d\n   data: [ " + data + " ]\n";
}

std::string xml_matrix(const std::string& key, int rows, int cols, const std::string& data) {
    return '<' + key + " type_id=\"opencv-matrix\">\n  <rows>" + std::to_string(rows) +
           "</rows>\n  <cols>" + std::to_string(cols) + "</cols>\n  <dt>d</dt>\n  <data>\n    " +
           data + "</data></" + key + ">\n";
}

class ReadRigTest : public testing::Test {
protected:
    fs::path file(const std::string& name, const std::string& text) {
        std::ofstream(folder_ / name, std::ios::binary) << text;
        return folder_ / name;
    }
    RigFiles read(const std::vector<fs::path>& files) { return read_rig(files, findings_, hints_); }
    std::string refusal_of(const std::vector<fs::path>& files) {
        try {
            read(files);
        } catch (const Error& error) {
            return error.what();
        }
        return "";
    }
    bool has_code(const std::string& code) const {
        for (const Finding& finding : findings_.all())
            if (finding.code == code) return true;
        return false;
    }
    // Checks the numbers that all files of these tests state, and the relative pose.
    void expect_true_rig(const RigFiles& rig, double tolerance_m = 1e-12) const {
        EXPECT_EQ(rig.cam0.camera.width_px, 640);
        EXPECT_EQ(rig.cam0.camera.height_px, 480);
        EXPECT_EQ(rig.cam0.camera.fx_px, 489.6);
        EXPECT_EQ(rig.cam0.camera.fy_px, 489.1);
        EXPECT_EQ(rig.cam0.camera.cx_px, 320.9);
        EXPECT_EQ(rig.cam0.camera.cy_px, 238.8);
        EXPECT_EQ(rig.cam1.camera.fx_px, 490.3);
        EXPECT_EQ(rig.cam0.camera.distortion, types::Distortion::RadialTangential);
        EXPECT_EQ(rig.cam0.camera.distortion_coefficients,
                  (std::array{-0.121, 0.0312, 0.00041, -0.00032}));
        EXPECT_EQ(rig.cam1.camera.distortion_coefficients[0], -0.119);
        // A point 1.7 m before the right camera, where the left one sees it.
        const Eigen::Vector3d p_cam1(0.3, -0.2, 1.7);
        const Eigen::Vector3d p_cam0 = rig.cam0.T_body_cam.inverse() * rig.cam1.T_body_cam * p_cam1;
        EXPECT_LT((p_cam0 - truth_.T_cam0_cam1 * p_cam1).norm(), tolerance_m);
    }
    void expect_true_mounting(const RigFiles& rig) const {
        EXPECT_LT((rig.cam0.T_body_cam.matrix() - truth_.T_imu_cam0.matrix()).norm(), 1e-12);
        EXPECT_LT((rig.cam1.T_body_cam.matrix() - truth_.T_imu_cam1().matrix()).norm(), 1e-12);
    }

    std::string kalibr_camera(const char* name, const std::string& poses, bool is_right) const {
        return std::string(name) + ":\n" + poses +
               "  cam_overlaps: [1]\n  camera_model: pinhole\n  distortion_coeffs: " +
               (is_right ? "[-0.119, 0.0302, -0.0003,\n    0.0005]"
                         : "[-0.121, 0.0312, 0.00041,\n    -0.00032]") +
               "\n  distortion_model: radtan\n  intrinsics: " +
               (is_right ? "[490.3, 489.9, 318.2, 241.5]" : "[489.6, 489.1, 320.9, 238.8]") +
               "\n  resolution: [640, 480]\n  rostopic: /" + name + "/image_raw\n";
    }
    std::string camchain() const {
        return kalibr_camera("cam0", "", false) +
               kalibr_camera(
                   "cam1", kalibr_matrix("T_cn_cnm1", truth_.T_cam0_cam1.inverse()), true);
    }
    std::string camchain_imucam() const {
        return kalibr_camera(
                   "cam0", kalibr_matrix("T_cam_imu", truth_.T_imu_cam0.inverse()), false) +
               "  timeshift_cam_imu: -0.004\n" +
               kalibr_camera("cam1",
                             kalibr_matrix("T_cam_imu", truth_.T_imu_cam1().inverse()) +
                                 kalibr_matrix("T_cn_cnm1", truth_.T_cam0_cam1.inverse()),
                             true) +
               "  timeshift_cam_imu: -0.004\n";
    }
    std::string intrinsics_yml(const char* m = "M", const char* d = "D") const {
        const std::string M(m);
        const std::string D(d);
        return "%YAML:1.0\n---\n" + opencv_matrix((M + "1").c_str(), 3, 3, kLeft) +
               opencv_matrix((D + "1").c_str(), 1, 5, kLeftLens) +
               opencv_matrix((M + "2").c_str(), 3, 3, kRight) +
               opencv_matrix((D + "2").c_str(), 1, 5, kRightLens);
    }
    // stereoCalibrate gives p_cam1 = R p_cam0 + T.
    std::string extrinsics_yml(double unit_m = 1.0) const {
        const Eigen::Isometry3d T_cam1_cam0 = truth_.T_cam0_cam1.inverse();
        return "%YAML:1.0\n---\n" + opencv_matrix("R", 3, 3, numbers(T_cam1_cam0.linear())) +
               opencv_matrix("T", 3, 1, numbers(T_cam1_cam0.translation(), ", ", unit_m)) +
               opencv_matrix("R1", 3, 3, "1., 0., 0., 0., 1., 0., 0., 0., 1.") +
               opencv_matrix("P1", 3, 4, "500., 0., 320., 0., 0., 500., 240., 0., 0., 0., 1., 0.");
    }

    static constexpr const char* kLeft =
        "4.8960000000000002e+02, 0., 3.2089999999999998e+02, 0.,\n"
        "       4.8910000000000002e+02, 2.3880000000000001e+02, 0., 0., 1.";
    static constexpr const char* kRight = "490.3, 0., 318.2, 0., 489.9, 241.5, 0., 0., 1.";
    static constexpr const char* kLeftLens = "-1.21e-01, 3.12e-02, 4.1e-04, -3.2e-04, 0.";
    static constexpr const char* kRightLens = "-0.119, 0.0302, -0.0003, 0.0005, 0.";

    TrueRig truth_;
    TemporaryFolder folder_;
    dive::FindingLog findings_;
    RigHints hints_;
};

TEST_F(ReadRigTest, AChainOfKalibrWithoutAnImuHasTheLeftCameraAsItsBody) {
    const RigFiles rig = read({file("a.txt", camchain())});
    expect_true_rig(rig);
    EXPECT_TRUE(rig.cam0.T_body_cam.isApprox(Eigen::Isometry3d::Identity()));
    EXPECT_FALSE(rig.imu_yaml);
}

TEST_F(ReadRigTest, AChainOfKalibrWithAnImuGivesTheInverseOfTCamImu) {
    const std::string imu =
        "accelerometer_noise_density: 0.0021\naccelerometer_random_walk: 3.0e-05\n"
        "gyroscope_noise_density: 0.00017\ngyroscope_random_walk: 1.9e-05\n"
        "rostopic: /imu0\nupdate_rate: 200.0\n";
    const RigFiles rig = read({file("camchain-imucam.yaml", camchain_imucam()), file("i", imu)});
    expect_true_rig(rig);
    expect_true_mounting(rig);
    EXPECT_TRUE(has_code("calibration_time_offset"));
    EXPECT_FALSE(has_code("imu_noise_assumed"));
    const auto yaml = dive::parse_sensor_yaml(rig.imu_yaml.value(), "imu", findings_).value();
    EXPECT_EQ(yaml.gyroscope_noise_density, 0.00017);
    EXPECT_EQ(yaml.gyroscope_random_walk, 1.9e-05);
    EXPECT_EQ(yaml.accelerometer_noise_density, 0.0021);
    EXPECT_EQ(yaml.accelerometer_random_walk, 3.0e-05);
    EXPECT_TRUE(yaml.T_body_sensor->isIdentity());
}

TEST_F(ReadRigTest, OneTCamImuAndTheChainGiveTheSameRigAsBoth) {
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

TEST_F(ReadRigTest, CamerasOfAChainAreThoseOfTheTopics) {
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

TEST_F(ReadRigTest, AChainThatContradictsItselfIsRefused) {
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

TEST_F(ReadRigTest, ModelsOfKalibrThatAreNotReadAreRefusedWithWhatToDo) {
    for (const char* model : {"omni", "ds", "eucm"}) {
        std::string text = camchain();
        text.replace(text.find("pinhole"), 7, model);
        EXPECT_NE(refusal_of({file("c", text)}).find("pinhole-radtan"), std::string::npos) << model;
    }
    std::string equi = camchain();
    for (std::size_t at = equi.find("radtan"); at != equi.npos; at = equi.find("radtan"))
        equi.replace(at, 6, "equidistant");
    EXPECT_EQ(read({file("c", equi)}).cam1.camera.distortion, types::Distortion::Equidistant);
}

TEST_F(ReadRigTest, FilesOfOpenCvStateARigTogether) {
    const auto intrinsics = file("one", intrinsics_yml());
    const auto extrinsics = file("two", extrinsics_yml());
    EXPECT_NE(refusal_of({intrinsics, extrinsics}).find("--image-size"), std::string::npos);
    hints_.resolution = {640, 480};
    expect_true_rig(read({intrinsics, extrinsics}));
    expect_true_rig(read({extrinsics, intrinsics}));
    EXPECT_NE(refusal_of({intrinsics}).find("extrinsics.yml"), std::string::npos);
    EXPECT_NE(refusal_of({extrinsics}).find("not two"), std::string::npos);
    EXPECT_NE(refusal_of({intrinsics, extrinsics, intrinsics}).find("left camera"),
              std::string::npos);
}

TEST_F(ReadRigTest, OpenCvInMillimetresIsToldByItsSize) {
    hints_.resolution = {640, 480};
    const auto intrinsics = file("one", intrinsics_yml());
    expect_true_rig(read({intrinsics, file("two", extrinsics_yml(1e-3))}));
    EXPECT_TRUE(has_code("calibration_unit"));  // 120 could be in cm too
    const auto cm = file("two", extrinsics_yml(1e-2));
    EXPECT_NE(refusal_of({intrinsics, cm}).find("--calibration-unit"), std::string::npos);
    hints_.metres_per_unit = 1e-2;
    expect_true_rig(read({intrinsics, cm}));
}

TEST_F(ReadRigTest, NamesThatUsersOfOpenCvGiveAreRead) {
    hints_.resolution = {640, 480};
    const auto extrinsics = file("two", extrinsics_yml());
    for (const auto& [m, d] : {std::pair("K", "D"),
                               std::pair("cameraMatrix", "distCoeffs"),
                               std::pair("camera_matrix_", "dist_coeffs_"),
                               std::pair("CM", "DistCoeff")})
        expect_true_rig(read({file("one", intrinsics_yml(m, d)), extrinsics}));
    const auto side = [](const char* name, const char* k, const char* lens) {
        return opencv_matrix((std::string("K_") + name).c_str(), 3, 3, k) +
               opencv_matrix((std::string("D_") + name).c_str(), 5, 1, lens);
    };
    const std::string words = side("left", kLeft, kLeftLens) + side("right", kRight, kRightLens);
    expect_true_rig(read({file("one", "%YAML:1.0\n---\n" + words), extrinsics}));
    const std::string counted = side("0", kLeft, kLeftLens) + side("1", kRight, kRightLens);
    expect_true_rig(
        read({file("one", "%YAML:1.0\n---\nimageSize: [ 640, 480 ]\n" + counted), extrinsics}));
}

TEST_F(ReadRigTest, XmlAndJsonOfOpenCvAreReadAsItsYaml) {
    const Eigen::Isometry3d T_cam1_cam0 = truth_.T_cam0_cam1.inverse();
    const auto plain = [](std::string data) {
        for (char& c : data) c = c == ',' ? ' ' : c;
        return data;
    };
    const std::string xml =
        "<?xml version=\"1.0\"?>\n<!-- a rig "
        "-->\n<opencv_storage>\n<image_width>640</image_width>\n"
        "<image_height>480</image_height>\n" +
        xml_matrix("M1", 3, 3, plain(kLeft)) + xml_matrix("D1", 1, 5, plain(kLeftLens)) +
        xml_matrix("M2", 3, 3, plain(kRight)) + xml_matrix("D2", 1, 5, plain(kRightLens)) +
        xml_matrix("R", 3, 3, numbers(T_cam1_cam0.linear(), " ")) +
        xml_matrix("T", 3, 1, numbers(T_cam1_cam0.translation(), " ")) + "</opencv_storage>\n";
    expect_true_rig(read({file("rig.yaml", xml)}));
    const std::string json =
        std::string(
            "{\"image_size\":[640,480],\n\t\"K1\": [[489.6, 0, 320.9], [0, 489.1, 238.8], "
            "[0, 0, 1]], \"D1\": [[-0.121, 0.0312, 0.00041, -0.00032, 0.0]],\n\t\"K2\": ["
            "490.3, 0, 318.2, 0, 489.9, 241.5, 0, 0, 1], \"D2\": [-0.119, 0.0302, "
            "-0.0003, 0.0005, 0],\n\t\"R\": [") +
        numbers(T_cam1_cam0.linear()) + "], \"T\": [" + numbers(T_cam1_cam0.translation()) + "]}";
    expect_true_rig(read({file("rig.yaml", json)}));
}

TEST_F(ReadRigTest, TwoCalibrationsOfOneCameraAreLeftAndRight) {
    const auto one = [](const char* k, const char* lens) {
        return "%YAML:1.0\n---\nimage_width: 640\nimage_height: 480\nboard_width: 9\n" +
               opencv_matrix("camera_matrix", 3, 3, k) +
               opencv_matrix("distortion_coefficients", 5, 1, lens);
    };
    expect_true_rig(read({file("l", one(kLeft, kLeftLens)),
                          file("r", one(kRight, kRightLens)),
                          file("e", extrinsics_yml())}));
}

TEST_F(ReadRigTest, KwiverIsReadInMillimetres) {
    const Eigen::Isometry3d T_cam1_cam0 = truth_.T_cam0_cam1.inverse();
    const std::string json =
        "{\n  \"image_width\": 640,\n  \"image_height\": 480,\n  \"square_size_mm\": 80.0,\n"
        "  \"T\": [" +
        numbers(T_cam1_cam0.translation(), ",\n    ", 1e-3) + "],\n  \"R\": [" +
        numbers(T_cam1_cam0.linear()) +
        "],\n  \"fx_left\": 489.6,\n  \"fy_left\": 489.1,\n  \"cx_left\": 320.9,\n"
        "  \"cy_left\": 238.8,\n  \"k1_left\": -0.121,\n  \"k2_left\": 0.0312,\n"
        "  \"p1_left\": 0.00041,\n  \"p2_left\": -0.00032,\n  \"k3_left\": 0.0,\n"
        "  \"fx_right\": 490.3,\n  \"fy_right\": 489.9,\n  \"cx_right\": 318.2,\n"
        "  \"cy_right\": 241.5,\n  \"k1_right\": -0.119,\n  \"k2_right\": 0.0302,\n"
        "  \"p1_right\": -0.0003,\n  \"p2_right\": 0.0005,\n  \"k3_right\": 0.0\n}";
    expect_true_rig(read({file("k", json)}));
    EXPECT_TRUE(findings_.all().empty());
    std::string without = json;
    without.replace(without.find("cy_left"), 7, "cy_lost");
    EXPECT_NE(refusal_of({file("k", without)}).find("cy_left"), std::string::npos);
}

TEST_F(ReadRigTest, CameraInfoOfBothCamerasIsAPairInEitherOrder) {
    const Eigen::Matrix3d R_rect_cam1 = truth_.T_cam0_cam1.linear();
    const auto info = [](const char* k, const char* lens, const std::string& R, double shift_m) {
        std::ostringstream text;
        text << "image_width: 640\nimage_height: 480\ncamera_name: narrow_stereo\ncamera_matrix:\n"
                "  rows: 3\n  cols: 3\n  data: ["
             << k
             << "]\ndistortion_model: plumb_bob\ndistortion_coefficients:\n  rows: 1\n  cols: 5\n"
                "  data: ["
             << lens << "]\nrectification_matrix:\n  rows: 3\n  cols: 3\n  data: [" << R
             << "]\nprojection_matrix:\n  rows: 3\n  cols: 4\n  data: [500, 0, 320, "
             << -500 * shift_m << ", 0, 500, 240, 0, 0, 0, 1, 0]\n";
        return text.str();
    };
    const auto left = file("l", info(kLeft, kLeftLens, "1, 0, 0, 0, 1, 0, 0, 0, 1", 0.0));
    const auto right = file("r", info(kRight, kRightLens, numbers(R_rect_cam1), 0.12));
    truth_.T_cam0_cam1.translation() = Eigen::Vector3d(0.12, 0, 0);
    expect_true_rig(read({left, right}));
    EXPECT_FALSE(has_code("calibration_sides"));
    expect_true_rig(read({right, left}));
    EXPECT_TRUE(has_code("calibration_sides"));
    EXPECT_NE(refusal_of({left}).find("two files"), std::string::npos);
    EXPECT_NE(refusal_of({left, left}).find("baseline"), std::string::npos);
}

TEST_F(ReadRigTest, CamerasOfColmapNeedAPoseAndLoseHalfAPixel) {
    const auto cameras = file("cameras.txt",
                              "# Camera list with one line of data per camera:\n"
                              "#   CAMERA_ID, MODEL, WIDTH, HEIGHT, PARAMS[]\n"
                              "2 OPENCV 640 480 490.3 489.9 318.7 242.0 -0.119 0.0302 -0.0003 "
                              "0.0005\n"
                              "1 OPENCV 640 480 489.6 489.1 321.4 239.3 -0.121 0.0312 0.00041 "
                              "-0.00032\n");
    EXPECT_NE(refusal_of({cameras}).find("where the cameras are"), std::string::npos);
    const RigFiles rig = read({cameras, file("e", extrinsics_yml())});
    EXPECT_NEAR(rig.cam0.camera.cx_px, 320.9, 1e-12);
    EXPECT_NEAR(rig.cam0.camera.cy_px, 238.8, 1e-12);
    EXPECT_EQ(rig.cam1.camera.fx_px, 490.3);
    const auto thin = file("t", "# CAMERA_ID, MODEL, WIDTH, HEIGHT\n1 THIN_PRISM 640 480 1 2\n");
    EXPECT_NE(refusal_of({thin}).find("OPENCV_FISHEYE"), std::string::npos);
}

TEST_F(ReadRigTest, ARigIsWrittenBesideTheImagesAndNeverOverAnother) {
    const RigFiles rig = read({file("c", camchain_imucam())});
    fs::create_directories(folder_ / "dive" / "mav0" / "cam0" / "data");
    write_rig(rig, folder_ / "dive");
    EXPECT_EQ(file_text(folder_ / "dive" / "mav0" / "cam1" / "sensor.yaml"), rig.cam1_yaml);
    const RigFiles again = read({folder_ / "dive"});
    expect_true_rig(again);
    expect_true_mounting(again);
    EXPECT_EQ(again.imu_yaml, rig.imu_yaml);
    EXPECT_THROW(write_rig(rig, folder_ / "dive" / "mav0"), Error);
}

TEST_F(ReadRigTest, HostileFilesAreRefusedWithAReason) {
    hints_.resolution = {640, 480};
    const std::string good = camchain();
    const auto with = [&](const char* old, const std::string& text) {
        std::string changed = good;
        return changed.replace(changed.find(old), std::string(old).size(), text);
    };
    const std::string deep(100'000, '[');
    const std::string nested = "<opencv_storage>" + [] {
        std::string tags;
        for (int i = 0; i < 50'000; ++i) tags += "<a>";
        return tags;
    }();
    const std::vector<std::string> texts = {
        "",
        " ",
        "\xEF\xBB\xBF",
        "{}",
        "[]",
        "1",
        "- 1\n- 2\n",
        deep,
        "T_cam_imu",
        "fx_left fx_right",
        "cam0:\n  T_cam_imu: 1\n",
        "cam0: 1\ncam1: 1\n# T_cam_imu",
        "cam0: &a [*a]\n# T_cam_imu",
        with("489.6", ".nan"),
        with("489.6", ".inf"),
        with("489.6", "0"),
        with("489.6", "-489.6"),
        with("489.6", "1e308"),
        with("[640, 480]", "[640]"),
        with("[640, 480]", "[-640, 480]"),
        with("[640, 480]", "[1e9, 1e9]"),
        with("radtan", "\"a\\ncamera_model: b\""),
        with("pinhole", std::string(5000, 'a')),
        with("cam1", "cam2"),
        with("cam1", "cam0"),
        with("T_cn_cnm1", "T_none"),
        with("-0.121,", ""),
        with("  - [0, 0, 0, 1]\n", "  - [1e200]\n"),
        std::string("<"),
        "<?xml",
        "<opencv_storage>",
        "<opencv_storage></opencv_storage>",
        "<opencv_storage><M1></M2></opencv_storage>",
        "<opencv_storage><M1>x</M1></opencv_storage>",
        "<opencv_storage><!-- ",
        "<html></html>",
        nested,
        "<opencv_storage><a/></opencv_storage>",
        "# CAMERA_ID, MODEL, WIDTH, HEIGHT\n",
        "# CAMERA_ID, MODEL, WIDTH, HEIGHT\n1\n",
        "# CAMERA_ID, MODEL, WIDTH, HEIGHT\n1 OPENCV 640 480 1 2 3\n",
        "# CAMERA_ID, MODEL, WIDTH, HEIGHT\n99999999999999 OPENCV 640 480\n",
        "image_width: 640\nimage_height: 1e30\ncamera_matrix: [1]\n",
        "image_width: -1\nimage_height: 480\ncamera_matrix: [1]\n",
        "image_width: 640\nimage_height: 480\ncamera_matrix: {rows: 3, cols: 3}\n",
        "M1: [1, 2]\nM2: [1, 2]\n",
        "M1: {data: [[1]]}\nM2: {data: x}\n",
        "R: [1]\nT: [1]\n",
        "R: [0, 0, 0]\nT: [0, 0, 0]\n",
        "R: [0, 0, 0]\nT: [1e300, 0, 0]\n",
        "{\"fx_left\": 1, \"fx_right\": 1e999}",
        std::string((1 << 20) + 1, ' ')};
    for (const std::string& text : texts)
        EXPECT_GT(refusal_of({file("c", text)}).size(), 40U) << text.substr(0, 300);
    EXPECT_GT(refusal_of({folder_ / "missing"}).size(), 20U);
    EXPECT_GT(refusal_of({}).size(), 20U);
    EXPECT_GT(refusal_of(std::vector(1000, file("c", good))).size(), 20U);
    EXPECT_EQ(refusal_of({file("c", good)}), "");
}

}  // namespace
}  // namespace divemesh::recording
