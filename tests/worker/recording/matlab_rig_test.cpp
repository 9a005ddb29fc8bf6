#include <cstdint>
#include <functional>
#include <opencv2/core.hpp>

#include "tests/worker/recording/calibration_files.hpp"
#include "tests/worker/recording/mat_writer.hpp"
#include "worker/recording/mat_file.hpp"

namespace divemesh::recording {
namespace {

WrittenMat matrix(const Eigen::MatrixXd& numbers) { return {numbers}; }
WrittenMat row(const std::vector<double>& numbers) {
    return {Eigen::MatrixXd(Eigen::Map<const Eigen::RowVectorXd>(
        numbers.data(), static_cast<Eigen::Index>(numbers.size())))};
}
WrittenMat column(const std::vector<double>& numbers) {
    return {Eigen::MatrixXd(std::get<Eigen::MatrixXd>(row(numbers).value).transpose())};
}

// Bytes of a MAT-file as its description states them.
std::string bytes_of(std::uint32_t number) {
    return std::string(reinterpret_cast<const char*>(&number), sizeof number);
}
std::string element(std::uint32_t type, std::string value) {
    std::string bytes = bytes_of(type) + bytes_of(static_cast<std::uint32_t>(value.size())) + value;
    bytes.resize((bytes.size() + 7) / 8 * 8);
    return bytes;
}
std::string mat_header(const std::string& text = "MATLAB 5.0 MAT-file") {
    std::string header = text;
    header.resize(124, ' ');
    return header + std::string("\0\1IM", 4);
}
std::string matrix_head(std::uint32_t class_of, std::uint32_t rows, const std::string& name) {
    return element(6, bytes_of(class_of) + bytes_of(0)) + element(5, bytes_of(rows) + bytes_of(1)) +
           element(1, name);
}

class MatlabRigTest : public CalibrationFilesTest {
protected:
    // The rig as toStruct(stereoParams) states it. OpenCV's p2 = R p1 + t of columns is
    // p2' = p1' R' + t' of Matlab's rows, and its first pixel is at (1, 1).
    WrittenStruct stereo_params() const {
        const Eigen::Isometry3d T_cam1_cam0 = truth_.T_cam0_cam1.inverse();
        const Eigen::Vector3d t_mm = 1e3 * T_cam1_cam0.translation();
        return {{"CameraParameters1",
                 {camera({489.6, 489.1, 321.9, 239.8}, {-0.121, 0.0312}, {0.00041, -0.00032})}},
                {"CameraParameters2",
                 {camera({490.3, 489.9, 319.2, 242.5}, {-0.119, 0.0302, 0.0}, {-0.0003, 0.0005})}},
                {"RotationOfCamera2", matrix(T_cam1_cam0.linear().transpose())},
                {"TranslationOfCamera2", matrix(t_mm.transpose())},
                {"Version", {WrittenStruct{{"Major", row({1})}}}}};
    }
    static WrittenStruct camera(const std::vector<double>& f_c,
                                const std::vector<double>& radial,
                                const std::vector<double>& tangential) {
        Eigen::Matrix3d K;
        K << f_c[0], 0, f_c[2], 0, f_c[1], f_c[3], 0, 0, 1;
        return {{"K", matrix(K)},
                {"RadialDistortion", row(radial)},
                {"TangentialDistortion", row(tangential)},
                {"ImageSize", row({480, 640})},
                {"WorldUnits", {std::string("millimeters")}},
                {"WorldPoints", matrix(Eigen::MatrixXd::Random(54, 2))},
                {"ReprojectionErrors", matrix(Eigen::MatrixXd::Random(3000, 2))},
                {"NumRadialDistortionCoefficients", row({2})}};
    }
    WrittenStruct toolbox() const {
        const Eigen::Isometry3d T_cam1_cam0 = truth_.T_cam0_cam1.inverse();
        return {{"fc_left", column({489.6, 489.1})},
                {"cc_left", column({320.9, 238.8})},
                {"alpha_c_left", row({0})},
                {"kc_left", column({-0.121, 0.0312, 0.00041, -0.00032, 0.0})},
                {"fc_right", column({490.3, 489.9})},
                {"cc_right", column({318.2, 241.5})},
                {"kc_right", column({-0.119, 0.0302, -0.0003, 0.0005, 0.0})},
                {"nx", row({640})},
                {"ny", row({480})},
                {"R", matrix(T_cam1_cam0.linear())},
                {"T", matrix(1e3 * T_cam1_cam0.translation())}};
    }
    fs::path mat(const WrittenStruct& variables,
                 matio_compression compression = MAT_COMPRESSION_ZLIB) {
        write_mat(folder_ / "rig.mat", variables, compression);
        return folder_ / "rig.mat";
    }
    // Changes a field of CameraParameters1.
    static WrittenStruct& first_camera(WrittenStruct& stereo) {
        return std::get<WrittenStruct>(stereo.at("CameraParameters1").value);
    }
    std::string written_bytes(const WrittenStruct& variables, matio_compression compression) {
        std::ifstream stream(mat(variables, compression), std::ios::binary);
        std::ostringstream text;
        text << stream.rdbuf();
        return text.str();
    }
};

TEST_F(MatlabRigTest, TheStructOfStereoParamsIsTheRigOfOpenCvsFiles) {
    hints_.resolution = {640, 480};
    const RigFiles opencv =
        read({file("i.yml", intrinsics_yml()), file("e.yml", extrinsics_yml())});
    hints_.resolution.clear();
    for (const auto compression : {MAT_COMPRESSION_NONE, MAT_COMPRESSION_ZLIB})
        for (const WrittenStruct& variables :
             {stereo_params(), WrittenStruct{{"s", {stereo_params()}}, {"note", row({7})}}}) {
            const RigFiles rig = read({mat(variables, compression)});
            expect_true_rig(rig);
            EXPECT_LT((rig.cam1.T_body_cam.matrix() - opencv.cam1.T_body_cam.matrix()).norm(),
                      1e-12);
            EXPECT_EQ(rig.cam1.camera.cx_px, opencv.cam1.camera.cx_px);
            EXPECT_EQ(rig.cam1.camera.cy_px, opencv.cam1.camera.cy_px);
            EXPECT_EQ(rig.cam1.camera.distortion_coefficients,
                      opencv.cam1.camera.distortion_coefficients);
        }
    EXPECT_FALSE(has_code("calibration_unit"));
}

TEST_F(MatlabRigTest, MatlabsRotationActsOnRows) {
    // A point that both cameras see, by Matlab's own formula.
    const auto stereo = stereo_params();
    const Eigen::RowVector3d p_cam1 =
        Eigen::RowVector3d(0.3, -0.2, 1.7) *
            std::get<Eigen::MatrixXd>(stereo.at("RotationOfCamera2").value) +
        1e-3 * std::get<Eigen::MatrixXd>(stereo.at("TranslationOfCamera2").value);
    const RigFiles rig = read({mat(stereo)});
    const Eigen::Vector3d p_cam0 =
        rig.cam0.T_body_cam.inverse() * rig.cam1.T_body_cam * p_cam1.transpose();
    EXPECT_LT((p_cam0 - Eigen::Vector3d(0.3, -0.2, 1.7)).norm(), 1e-12);
}

TEST_F(MatlabRigTest, OlderStructsHaveTheTransposeOfKAndSomeThreeRadialCoefficients) {
    WrittenStruct stereo = stereo_params();
    WrittenStruct& camera = first_camera(stereo);
    const Eigen::MatrixXd K = std::get<Eigen::MatrixXd>(camera.at("K").value);
    camera.erase("K");
    camera["IntrinsicMatrix"] = matrix(K.transpose());
    expect_true_rig(read({mat(stereo)}));
    camera["RadialDistortion"] = row({-0.121, 0.0312, 0.007});
    EXPECT_EQ(read({mat(stereo)}).cam0.camera.distortion_coefficients,
              (types::LensCoefficients{-0.121, 0.0312, 0.00041, -0.00032, 0.007}));
}

TEST_F(MatlabRigTest, TheUnitIsThatOfTheStructUnlessItIsStated) {
    WrittenStruct stereo = stereo_params();
    const Eigen::MatrixXd t_mm = std::get<Eigen::MatrixXd>(stereo.at("TranslationOfCamera2").value);
    first_camera(stereo)["WorldUnits"] = {std::string("inches")};
    stereo["TranslationOfCamera2"] = matrix(t_mm / 25.4);
    expect_true_rig(read({mat(stereo)}));
    first_camera(stereo)["WorldUnits"] = {std::string("squares")};
    stereo["TranslationOfCamera2"] = matrix(t_mm);
    expect_true_rig(read({mat(stereo)}));
    EXPECT_TRUE(has_code("calibration_unit"));
    hints_.metres_per_unit = 1e-2;
    stereo["TranslationOfCamera2"] = matrix(0.1 * t_mm);
    expect_true_rig(read({mat(stereo)}));
}

TEST_F(MatlabRigTest, VariablesOfBouguetsToolboxAreARig) {
    expect_true_rig(read({mat(toolbox())}));
    WrittenStruct by_vector = toolbox();
    by_vector.erase("R");
    const Eigen::AngleAxisd rotation(truth_.T_cam0_cam1.inverse().linear());
    by_vector["om"] = matrix(rotation.angle() * rotation.axis());
    expect_true_rig(read({mat(by_vector)}));
    by_vector["alpha_c_left"] = row({1e-3});
    EXPECT_NE(refusal_of({mat(by_vector)}).find("skew"), std::string::npos);
}

TEST_F(MatlabRigTest, AnObjectOfAClassIsRefusedWithTheRemedy) {
    // As save('rig.mat', 'stereoParams') writes it: class 17 without a size, its name, its system.
    const std::string object = element(6, bytes_of(17) + bytes_of(0)) + element(1, "stereoParams") +
                               element(1, "MCOS") + element(1, "stereoParameters") +
                               element(14, matrix_head(13, 6, "") + element(6, std::string(24, 1)));
    const std::string why = refusal_of({file("o.mat", mat_header() + element(14, object))});
    EXPECT_NE(why.find("save('rig.mat', '-struct', 's')"), std::string::npos) << why;
}

TEST_F(MatlabRigTest, WhatIsNotReadIsRefusedWithWhatToDo) {
    const std::vector<std::pair<std::string, std::function<void(WrittenStruct&)>>> faults = {
        {"CameraParameters1", [](auto& stereo) { stereo.erase("CameraParameters1"); }},
        {"CameraParameters2", [](auto& stereo) { stereo.erase("CameraParameters2"); }},
        {"RotationOfCamera2",
         [](auto& stereo) {
             stereo["RotationOfCamera2"] = row({1, 2});
         }},
        {"rotation",
         [](auto& stereo) {
             stereo["RotationOfCamera2"] = row({1, 2, 3, 4, 5, 6, 7, 8, 9});
         }},
        {"TranslationOfCamera2", [](auto& stereo) { stereo.erase("TranslationOfCamera2"); }},
        {"TranslationOfCamera2",
         [](auto& stereo) {
             stereo["TranslationOfCamera2"] = row({NAN, 0, 0});
         }},
        {"IntrinsicMatrix", [](auto& stereo) { first_camera(stereo).erase("K"); }},
        {"K of 9",
         [](auto& stereo) {
             first_camera(stereo)["K"] = row({1, 2, 3});
         }},
        {"skew",
         [](auto& stereo) {
             Eigen::Matrix3d K = Eigen::Matrix3d::Identity();
             K(0, 1) = 0.5;
             first_camera(stereo)["K"] = matrix(K);
         }},
        {"RadialDistortion",
         [](auto& stereo) { first_camera(stereo)["RadialDistortion"] = row({1}); }}};
    for (const auto& [word, fault] : faults) {
        WrittenStruct stereo = stereo_params();
        fault(stereo);
        const std::string why = refusal_of({mat(stereo)});
        EXPECT_NE(why.find(word == "CameraParameters1" ? "toStruct" : word), std::string::npos)
            << word << ": " << why;
    }
    EXPECT_NE(refusal_of({file("h.mat", mat_header("MATLAB 7.3 MAT-file"))}).find("-v7"),
              std::string::npos);
    std::string big_endian = mat_header();
    big_endian.replace(126, 2, "MI");
    EXPECT_NE(refusal_of({file("b.mat", big_endian)}).find("order of bytes"), std::string::npos);
}

TEST_F(MatlabRigTest, SizesThatLieAreRefusedBeforeTheyAreAllocated) {
    const auto why = [&](const std::string& matrix) {
        return refusal_of({file("l.mat", mat_header() + element(14, matrix))});
    };
    const std::string number(8, '\1');
    EXPECT_NE(why(matrix_head(6, 2, "fc_left") + element(9, number)).find("its size states 2"),
              std::string::npos);
    EXPECT_NE(why(matrix_head(6, 0x80000000U, "fc_left") + element(9, number)).find("no size"),
              std::string::npos);
    // A matrix or a struct of a thousand million is passed over.
    for (const std::uint32_t class_of : {2U, 4U, 6U})
        EXPECT_NE(why(matrix_head(class_of, 1'000'000'000, "s")).find("holds neither"),
                  std::string::npos);
    std::string long_value = element(14, std::string(8, '\0'));
    long_value.replace(4, 4, bytes_of(0x7FFFFFF0U));
    EXPECT_NE(refusal_of({file("e.mat", mat_header() + long_value)}).find("longer than"),
              std::string::npos);
    std::string deep;
    for (int i = 0; i < 100; ++i)
        deep = element(14,
                       matrix_head(2, 1, "s") + element(5, bytes_of(8)) +
                           element(1, std::string("field\0\0\0", 8)) + deep);
    EXPECT_NE(refusal_of({file("d.mat", mat_header() + deep)}).find("more than any"),
              std::string::npos);
}

TEST_F(MatlabRigTest, EveryCutAndEveryBrokenByteEndsInARigOrAnError) {
    for (const auto compression : {MAT_COMPRESSION_NONE, MAT_COMPRESSION_ZLIB}) {
        const std::string whole = written_bytes(toolbox(), compression);
        for (std::size_t size = 20; size < whole.size(); size += 7)
            refusal_of({file("cut.mat", whole.substr(0, size))});
        cv::RNG random(5);
        for (int trial = 0; trial < 3000; ++trial) {
            std::string bytes = whole;
            for (int k = 0; k < 3; ++k)
                bytes[static_cast<std::size_t>(
                    random.uniform(128, static_cast<int>(bytes.size())))] =
                    static_cast<char>(random.uniform(0, 256));
            try {
                const MatValue variables = parse_mat(bytes, "broken.mat");
                EXPECT_LT(variables.fields.size(), 100U);
            } catch (const Error& error) {
                EXPECT_EQ(error.code(), ErrorCode::BadData);
            }
        }
    }
}

}  // namespace
}  // namespace divemesh::recording
