#include "worker/dive/lens_yaml.hpp"

#include <gtest/gtest.h>

#include "worker/dive/calibration.hpp"
#include "worker/dive/sensor_yaml_text.hpp"

namespace divemesh::dive {
namespace {

using types::Distortion;

constexpr const char* kFile = "mav0/cam0/sensor.yaml";

std::string text_of(const std::string& model,
                    const std::string& intrinsics,
                    const std::string& distortion,
                    const std::string& coefficients) {
    return "T_BS: [1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1]\nresolution: [640, 480]\ncamera_model: " +
           model + "\nintrinsics: [" + intrinsics + "]\ndistortion_model: " + distortion +
           "\ndistortion_coefficients: [" + coefficients + "]\n";
}

std::optional<types::Camera> camera_of(const std::string& text) {
    FindingLog findings;
    const auto yaml = parse_sensor_yaml(text, kFile, findings);
    if (!yaml) return std::nullopt;
    const auto camera = calibrated_camera(*yaml, kFile, findings);
    return camera ? std::optional(camera->camera) : std::nullopt;
}

// Returns the first error of a sensor.yaml: code and message; "" if it is read.
std::string error_of(const std::string& text) {
    FindingLog findings;
    const auto yaml = parse_sensor_yaml(text, kFile, findings);
    if (yaml) calibrated_camera(*yaml, kFile, findings);
    for (const Finding& finding : findings.all())
        if (finding.severity == Severity::Error) return finding.code + ": " + finding.message;
    return "";
}

constexpr const char* kPinhole = "460, 459, 321, 238";

TEST(LensYamlTest, FourFiveAndEightCoefficientsOfOpenCvAreRead) {
    for (const char* name : {"radial-tangential", "radtan", "plumb_bob", "rational_polynomial"}) {
        const auto four = camera_of(text_of("pinhole", kPinhole, name, "-0.1, 0.02, 1e-4, 2e-4"));
        ASSERT_TRUE(four) << name;
        EXPECT_EQ(four->distortion, Distortion::RadialTangential);
        const auto zeros =
            camera_of(text_of("pinhole", kPinhole, name, "-0.1, 0.02, 1e-4, 2e-4, 0, 0, 0, 0"));
        ASSERT_TRUE(zeros);
        EXPECT_EQ(zeros->distortion, Distortion::RadialTangential);
        const auto five =
            camera_of(text_of("pinhole", kPinhole, name, "-0.1, 0.02, 1e-4, 2e-4, -0.003"));
        ASSERT_TRUE(five);
        EXPECT_EQ(five->distortion, Distortion::Rational);
        EXPECT_EQ(five->distortion_coefficients,
                  (types::LensCoefficients{-0.1, 0.02, 1e-4, 2e-4, -0.003}));
        // Twelve with the thin prism of OpenCV, which are 0.
        const auto eight = camera_of(text_of(
            "pinhole", kPinhole, name, "0.2, 0.02, 1e-4, 2e-4, 1e-3, 0.3, 0.05, 2e-3, 0, 0, 0, 0"));
        ASSERT_TRUE(eight);
        EXPECT_EQ(eight->distortion_coefficients,
                  (types::LensCoefficients{0.2, 0.02, 1e-4, 2e-4, 1e-3, 0.3, 0.05, 2e-3}));
    }
}

TEST(LensYamlTest, ModelsOfKalibrAreReadWithTheFocalLengthOnTheAxis) {
    const auto omni =
        camera_of(text_of("omni", "1.5, 1150, 1148, 321, 238", "radtan", "-0.1, 0.2, 1e-4, 2e-4"));
    ASSERT_TRUE(omni);
    EXPECT_EQ(omni->distortion_coefficients, (types::LensCoefficients{1.5, -0.1, 0.2, 1e-4, 2e-4}));
    EXPECT_DOUBLE_EQ(omni->fx_px, 460.0);
    const auto without = camera_of(text_of("omni", "1.5, 1150, 1148, 321, 238", "none", ""));
    ASSERT_TRUE(without);
    EXPECT_EQ(without->distortion_coefficients, (types::LensCoefficients{1.5}));
    const auto ds = camera_of(text_of("ds", "-0.2, 0.6, 368, 367, 321, 238", "none", ""));
    ASSERT_TRUE(ds);
    EXPECT_EQ(ds->distortion, Distortion::DoubleSphere);
    EXPECT_DOUBLE_EQ(ds->fx_px, 460.0);
    const auto eucm = camera_of(text_of("eucm", "0.6, 1.1, 460, 459, 321, 238", "none", ""));
    ASSERT_TRUE(eucm);
    EXPECT_EQ(eucm->distortion, Distortion::ExtendedUnified);
    EXPECT_EQ(eucm->cy_px, 238.0);
}

TEST(LensYamlTest, WhatIsWrittenIsReadBack) {
    for (const camera::LensModel& model : camera::lens_models()) {
        types::Camera camera{640, 480, 460.0, 459.0, 321.0, 238.0, model.distortion, {}};
        auto& k = camera.distortion_coefficients;
        for (std::size_t i = 0; i < model.num_coefficients; ++i)
            k[i] = 0.01 + 0.001 * static_cast<double>(i);
        if (model.distortion == Distortion::ExtendedUnified) k = {0.6, 1.1};
        SensorYaml yaml;
        yaml.T_body_sensor = Eigen::Matrix4d::Identity();
        yaml.resolution = {640, 480};
        state_lens(camera, yaml);

        const auto read = camera_of(camera_yaml_text(yaml, {"test"}));

        ASSERT_TRUE(read) << model.name;
        EXPECT_EQ(read->distortion, model.distortion);
        EXPECT_EQ(read->distortion_coefficients, k) << model.name;
        EXPECT_NEAR(read->fx_px, camera.fx_px, 1e-10);
        EXPECT_NEAR(read->fy_px, camera.fy_px, 1e-10);
        EXPECT_EQ(read->cx_px, camera.cx_px);
    }
}

TEST(LensYamlTest, WhatNoLensHasIsRefusedWithTheReason) {
    const auto expect = [](const std::string& text, const char* code, const char* what) {
        const std::string error = error_of(text);
        EXPECT_EQ(error.rfind(code, 0), 0U) << text << error;
        EXPECT_NE(error.find(what), std::string::npos) << error;
    };
    const char* const kIntrinsics = "calibration_intrinsics";
    const char* const kDistortion = "calibration_distortion";
    expect(text_of("fov", kPinhole, "none", ""), "calibration_model", "eucm");
    expect(text_of("ds", kPinhole, "none", ""), kIntrinsics, "instead of 6");
    expect(text_of("eucm", "0.6", "none", ""), kIntrinsics, "instead of 6");
    expect(text_of("omni", "", "none", ""), kIntrinsics, "instead of 5");
    expect(text_of("ds", "-1, 0.6, 460, 459, 321, 238", "none", ""), kIntrinsics, "xi is -1");
    expect(text_of("ds", "460, 459, 321, 238, -0.2, 0.6", "none", ""), kIntrinsics, "xi is 460");
    expect(text_of("ds", "-0.2, 1.1, 460, 459, 321, 238", "none", ""), kIntrinsics, "alpha");
    expect(text_of("eucm", "0.6, 0, 460, 459, 321, 238", "none", ""), kIntrinsics, "beta");
    expect(text_of("eucm", "0.6, -1, 460, 459, 321, 238", "none", ""), kIntrinsics, "beta");
    expect(text_of("omni", "-1, 460, 459, 321, 238", "none", ""), kIntrinsics, "xi");
    expect(text_of("omni", "1e300, 460, 459, 321, 238", "none", ""), kIntrinsics, "xi");
    // 20 px on the axis.
    expect(text_of("omni", "9, 200, 200, 321, 238", "none", ""), kIntrinsics, "focal");
    expect(text_of("omni", "1, 0, 460, 321, 238", "none", ""), "calibration_not_invertible", "0");
    expect(text_of("ds", "-0.2, 0.6, .nan, 459, 321, 238", "none", ""), "calibration_", "");
    expect(
        text_of("ds", "-0.2, 0.6, 368, 367, 321, 238", "radtan", "0, 0, 0, 0"), kDistortion, "ds");
    expect(text_of("omni", "1, 920, 918, 321, 238", "equi", "0, 0, 0, 0"), kDistortion, "omni");
    expect(text_of("omni", "1, 920, 918, 321, 238", "radtan", "0, 0"), kDistortion, "2 numbers");
    expect(text_of("omni", "1, 920, 918, 321, 238", "radtan", "0, 0, 0, 0, 1"), kDistortion, "5");
    expect(text_of("pinhole", kPinhole, "radtan", "-0.1"), kDistortion, "4, 5 or 8");
    expect(text_of("pinhole", kPinhole, "radtan", "0,0,0,0,0,0,0,0,1"), kDistortion, "9 numbers");
    expect(text_of("pinhole", kPinhole, "equi", "0, 0, 0, 0, 1"), kDistortion, "has 4");
    // No ray is seen further than 0.18 focal lengths from the principal point.
    expect(text_of("pinhole", kPinhole, "radtan", "0, 0, 0, 0, 0, 8, 0, 0"),
           "calibration_not_invertible",
           "folds");
    std::string many;
    for (int i = 0; i < 9000; ++i) many += "0, ";
    EXPECT_EQ(error_of(text_of("pinhole", kPinhole, "radtan", many + "0")), "");
    expect(text_of("pinhole", kPinhole, "radtan", many + "1"), kDistortion, "9001 numbers");
}

}  // namespace
}  // namespace divemesh::dive
