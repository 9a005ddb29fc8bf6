#include "worker/io/rig_json.hpp"

#include <gtest/gtest.h>

#include "schemas/error.hpp"
#include "worker/camera/lens_model.hpp"

namespace divemesh::io {
namespace {

TEST(RigJsonTest, GivesBackTheRigThatWasWritten) {
    types::Rig rig;
    rig.cam0 = {640, 480, 490.5, 491.25, 320.0, 240.5, types::Distortion::Equidistant};
    rig.cam0.distortion_coefficients = {0.1, -0.02, 0.003, -0.0004};
    rig.cam1 = {641, 481, 488.0, 489.0, 318.0, 241.0, types::Distortion::None};
    rig.cam1.refractive_index = 1.337;
    rig.T_imu_cam0.rotate(Eigen::AngleAxisd(2.0, Eigen::Vector3d(1.0, 2.0, 3.0).normalized()));
    rig.T_imu_cam0.translation() = Eigen::Vector3d(0.1, -0.2, 0.3);
    rig.T_imu_cam1.translation().x() = 0.12;

    const types::Rig read = rig_from_json(nlohmann::json::parse(to_json(rig).dump()));

    EXPECT_TRUE(read.T_imu_cam0.isApprox(rig.T_imu_cam0, 1e-12));
    EXPECT_TRUE(read.T_imu_cam1.isApprox(rig.T_imu_cam1, 1e-12));
    EXPECT_EQ(read.cam0.fy_px, 491.25);
    EXPECT_EQ(read.cam0.cy_px, 240.5);
    EXPECT_EQ(read.cam0.distortion, types::Distortion::Equidistant);
    EXPECT_EQ(read.cam0.distortion_coefficients, rig.cam0.distortion_coefficients);
    EXPECT_EQ(read.cam1.width_px, 641);
    EXPECT_EQ(read.cam1.height_px, 481);
    EXPECT_EQ(read.cam1.distortion, types::Distortion::None);
    EXPECT_EQ(read.cam0.refractive_index, 1.0);
    EXPECT_EQ(read.cam1.refractive_index, 1.337);
}

TEST(RigJsonTest, GivesBackEveryLensModel) {
    for (const camera::LensModel& model : camera::lens_models()) {
        types::Rig rig;
        rig.cam1.distortion = model.distortion;
        for (std::size_t i = 0; i < model.num_coefficients; ++i)
            rig.cam1.distortion_coefficients[i] = 0.1 * static_cast<double>(i + 1);
        EXPECT_FALSE(to_string(model.distortion).empty());

        const types::Camera read = rig_from_json(to_json(rig)).cam1;

        EXPECT_EQ(read.distortion, model.distortion);
        EXPECT_EQ(read.distortion_coefficients, rig.cam1.distortion_coefficients);
    }
}

TEST(RigJsonTest, GivesBackThePortsOfACamera) {
    types::Rig rig;
    rig.cam0.port = types::Port{.normal = {0.1, -0.2, 0.97},
                                .distance_m = 0.025,
                                .thickness_m = 0.006,
                                .glass_index = 1.5,
                                .water_index = 1.34,
                                .p_lens_cam = {0.001, 0.002, -0.009},
                                .reference_depth_m = 1.2};
    rig.cam1.port = types::Port{.shape = types::Port::Shape::Dome,
                                .centre_m = {0.001, 0.0, -0.003},
                                .radius_m = 0.05,
                                .water_index = 1.33};

    const types::Rig read = rig_from_json(nlohmann::json::parse(to_json(rig).dump()));

    ASSERT_TRUE(read.cam0.port && read.cam1.port);
    EXPECT_EQ(read.cam0.port->shape, types::Port::Shape::Flat);
    EXPECT_EQ(read.cam0.port->normal, rig.cam0.port->normal);
    EXPECT_EQ(read.cam0.port->distance_m, 0.025);
    EXPECT_EQ(read.cam0.port->thickness_m, 0.006);
    EXPECT_EQ(read.cam0.port->glass_index, 1.5);
    EXPECT_EQ(read.cam0.port->water_index, 1.34);
    EXPECT_EQ(read.cam0.port->p_lens_cam, rig.cam0.port->p_lens_cam);
    EXPECT_EQ(read.cam0.port->reference_depth_m, 1.2);
    EXPECT_EQ(read.cam1.port->shape, types::Port::Shape::Dome);
    EXPECT_EQ(read.cam1.port->centre_m, rig.cam1.port->centre_m);
    EXPECT_EQ(read.cam1.port->radius_m, 0.05);
    nlohmann::json unknown = to_json(rig);
    unknown["cam0"]["port"]["type"] = "bottle";
    EXPECT_THROW(rig_from_json(unknown), Error);
}

TEST(RigJsonTest, RefusesMoreCoefficientsThanAnyLensHas) {
    nlohmann::json entry = to_json(types::Rig());
    EXPECT_EQ(entry["cam1"]["distortion"].size(), 4U);
    entry["cam1"]["distortion"] = std::vector<double>(9, 0.0);
    EXPECT_THROW(rig_from_json(entry), Error);
}

TEST(RigJsonTest, RefusesALensThatItDoesNotKnow) {
    nlohmann::json entry = to_json(types::Rig());
    entry["cam1"]["distortion_model"] = "magic";
    EXPECT_THROW(rig_from_json(entry), Error);
}

}  // namespace
}  // namespace divemesh::io
