#include "worker/recording/read_rig.hpp"

#include <opencv2/core/persistence.hpp>

#include "tests/worker/recording/calibration_files.hpp"

namespace divemesh::recording {
namespace {

std::string file_text(const fs::path& file) {
    std::ostringstream text;
    text << std::ifstream(file, std::ios::binary).rdbuf();
    return text.str();
}

class ReadRigTest : public CalibrationFilesTest {};

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

TEST_F(ReadRigTest, WhatOpenCvItselfWritesIsRead) {
    const auto matrix = [](const auto& values) {
        cv::Mat copied(static_cast<int>(values.rows()), static_cast<int>(values.cols()), CV_64F);
        for (int row = 0; row < copied.rows; ++row)
            for (int column = 0; column < copied.cols; ++column)
                copied.at<double>(row, column) = values(row, column);
        return copied;
    };
    const Eigen::Isometry3d T_cam1_cam0 = truth_.T_cam0_cam1.inverse();
    for (const char* ending : {".yml", ".xml", ".json"}) {
        const fs::path rig = folder_ / (std::string("rig") + ending);
        cv::FileStorage storage(rig.string(), cv::FileStorage::WRITE);
        storage << "imageSize" << cv::Size(640, 480);
        storage << "M1" << (cv::Mat_<double>(3, 3) << 489.6, 0, 320.9, 0, 489.1, 238.8, 0, 0, 1);
        storage << "D1" << (cv::Mat_<double>(1, 5) << -0.121, 0.0312, 0.00041, -0.00032, 0);
        storage << "M2" << (cv::Mat_<double>(3, 3) << 490.3, 0, 318.2, 0, 489.9, 241.5, 0, 0, 1);
        storage << "D2" << (cv::Mat_<double>(1, 5) << -0.119, 0.0302, -0.0003, 0.0005, 0);
        storage << "R" << matrix(T_cam1_cam0.linear()) << "T" << matrix(T_cam1_cam0.translation());
        storage.release();
        fs::rename(rig, folder_ / "rig");  // its contents alone say what it is
        SCOPED_TRACE(ending);
        expect_true_rig(read({folder_ / "rig"}));
    }
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
    const std::string opencv =
        "K1: [500, 0, 320, 0, 500, 240, 0, 0, 1]\nK2: [500, 0, 320, 0, 500, 240, 0, 0, 1]\n";
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
        opencv + "R: [1e308, 1e308, 0]\nT: [0.1, 0, 0]\n",
        opencv + "R: [1e200, 0, 0, 0, 1, 0, 0, 0, 1]\nT: [0.1, 0, 0]\n",
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
