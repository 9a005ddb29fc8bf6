#pragma once

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <array>
#include <fstream>
#include <sstream>

#include "schemas/error.hpp"
#include "tests/temporary_folder.hpp"
#include "worker/recording/read_rig.hpp"

namespace divemesh::recording {

namespace fs = std::filesystem;

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
inline std::string kalibr_matrix(const char* key, const Eigen::Isometry3d& T) {
    std::string text = std::string("  ") + key + ":\n";
    for (int row = 0; row < 4; ++row) text += "  - [" + numbers(T.matrix().row(row)) + "]\n";
    return text;
}

// As cv::FileStorage writes a matrix.
inline std::string opencv_matrix(const char* key, int rows, int cols, const std::string& data) {
    return std::string(key) + ": !!opencv-matrix\n   rows: " + std::to_string(rows) +
           "\n   cols: " + std::to_string(cols) + "\n   dt: d\n   data: [ " + data + " ]\n";
}

inline std::string xml_matrix(const std::string& key, int rows, int cols, const std::string& data) {
    return '<' + key + " type_id=\"opencv-matrix\">\n  <rows>" + std::to_string(rows) +
           "</rows>\n  <cols>" + std::to_string(cols) + "</cols>\n  <dt>d</dt>\n  <data>\n    " +
           data + "</data></" + key + ">\n";
}

// Writes files as other programs do, all of the same rig, and reads them.
class CalibrationFilesTest : public testing::Test {
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
                  (types::LensCoefficients{-0.121, 0.0312, 0.00041, -0.00032}));
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

}  // namespace divemesh::recording
