#include "worker/dive/port_yaml.hpp"

#include <gtest/gtest.h>

#include "tests/temporary_folder.hpp"
#include "tests/worker/dive/finding_matcher.hpp"
#include "tests/worker/dive/tiny_dive.hpp"
#include "worker/camera/water_index.hpp"
#include "worker/dive/calibration.hpp"
#include "worker/dive/dive.hpp"
#include "worker/dive/sensor_yaml_text.hpp"

namespace divemesh::dive {
namespace {

using types::Port;

constexpr const char* kFile = "mav0/cam0/sensor.yaml";
constexpr const char* kIdentity = "1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1";
constexpr const char* kFlat =
    "port: {type: flat, normal: [0.02, 0, 2], distance_m: 0.025, thickness_m: 0.006, "
    "glass_index: 1.49}\n";

std::optional<Port> port_in(const std::string& text, FindingLog& findings) {
    const auto yaml = parse_sensor_yaml(camera_yaml(kIdentity) + text, kFile, findings);
    const auto camera = yaml ? calibrated_camera(*yaml, kFile, findings) : std::nullopt;
    return camera ? camera->camera.port : std::nullopt;
}

// Returns the message of the first error; "" if the port is read.
std::string error_of(const std::string& text) {
    FindingLog findings;
    port_in("port: {" + text + "}\n", findings);
    for (const Finding& finding : findings.all())
        if (finding.severity == Severity::Error) return finding.code + ": " + finding.message;
    return "";
}

TEST(PortYamlTest, AFlatPortIsReadWithAUnitNormal) {
    FindingLog findings;
    const auto port = port_in(kFlat, findings);
    ASSERT_TRUE(port);
    EXPECT_EQ(port->shape, Port::Shape::Flat);
    EXPECT_LT((port->normal - Eigen::Vector3d(0.01, 0.0, 1.0).normalized()).norm(), 1e-15);
    EXPECT_EQ(port->distance_m, 0.025);
    EXPECT_EQ(port->thickness_m, 0.006);
    EXPECT_EQ(port->glass_index, 1.49);
    EXPECT_EQ(port->water_index, 0.0);
}

TEST(PortYamlTest, ADomeIsRead) {
    FindingLog findings;
    const auto port = port_in(
        "port:\n  type: dome\n  centre_m: [0.001, 0, -0.003]\n  radius_m: 0.05\n"
        "  thickness_m: 0.004\n  glass_index: 1.52\n  water_index: 1.34\n",
        findings);
    ASSERT_TRUE(port);
    EXPECT_EQ(port->shape, Port::Shape::Dome);
    EXPECT_EQ(port->centre_m, Eigen::Vector3d(0.001, 0.0, -0.003));
    EXPECT_EQ(port->radius_m, 0.05);
    EXPECT_EQ(port->water_index, 1.34);
}

TEST(PortYamlTest, WithoutTheKeyThereIsNoPort) {
    FindingLog findings;
    EXPECT_FALSE(port_in("", findings));
    EXPECT_TRUE(findings.all().empty());
}

TEST(PortYamlTest, APortThatIsWrongRefusesTheCalibrationByItsKey) {
    const std::string rest = ", thickness_m: 0.006, glass_index: 1.49";
    const std::string flat = "type: flat, normal: [0, 0, 1], distance_m: 0.025";
    for (const auto& [text, message] : {
             std::pair("type: bottle" + rest, "type is 'bottle'"),
             std::pair("type: flat, distance_m: 0.025" + rest, "no normal"),
             std::pair("type: flat, normal: [0, 1], distance_m: 0.025" + rest, "2 numbers"),
             std::pair("type: flat, normal: [0, 0, -1], distance_m: 0.025" + rest, "to the front"),
             std::pair("type: flat, normal: [0, 0, 1], distance_m: 25" + rest, "distance_m is not"),
             std::pair(flat + ", thickness_m: 0.006", "no glass_index"),
             std::pair(flat + ", thickness_m: 0.006, glass_index: 1.33", "glass_index is not"),
             std::pair(flat + rest + ", water_index: 1.0", "water_index is not"),
             std::pair(flat + rest + ", radius_m: 0.05", "a key 'radius_m'"),
             std::pair("type: dome, centre_m: [0, 0, 0.06], radius_m: 0.05" + rest, "not within"),
         }) {
        const std::string error = error_of(text);
        EXPECT_EQ(error.rfind("calibration_port: ", 0), 0U) << text << ": " << error;
        EXPECT_NE(error.find(message), std::string::npos) << text << ": " << error;
    }
    EXPECT_EQ(error_of("type: flat, normal: [0, 0, x]").rfind("calibration_unreadable", 0), 0U);
}

TEST(PortYamlTest, WhatIsWrittenIsReadAgain) {
    const Port dome{.shape = Port::Shape::Dome,
                    .centre_m = {0.001, 0.0, -0.003},
                    .radius_m = 0.05,
                    .thickness_m = 0.004,
                    .water_index = 1.34};
    const Port flat{.normal = Eigen::Vector3d(0.1, 0.2, 1.0).normalized(), .distance_m = 0.02};
    for (const Port& port : {dome, flat}) {
        FindingLog findings;
        auto yaml = parse_sensor_yaml(camera_yaml(kIdentity), kFile, findings);
        yaml->port = state_port(port);
        const auto again = parse_sensor_yaml(camera_yaml_text(*yaml, {}), kFile, findings);
        ASSERT_TRUE(again && again->port);
        const auto read = port_of(*again->port, kFile, findings);
        ASSERT_TRUE(read);
        EXPECT_EQ(read->shape, port.shape);
        EXPECT_LT((read->normal - port.normal).norm(), 1e-15);
        EXPECT_EQ(read->distance_m, port.distance_m);
        EXPECT_EQ(read->centre_m, port.centre_m);
        EXPECT_EQ(read->radius_m, port.radius_m);
        EXPECT_EQ(read->thickness_m, port.thickness_m);
        EXPECT_EQ(read->water_index, port.water_index);
    }
}

TEST(PortYamlTest, TheWaterOfTheDiveIsBeforeThePort) {
    const TemporaryFolder folder;
    const TinyDive tiny(folder / "dive");
    for (const char* camera : {"mav0/cam0/sensor.yaml", "mav0/cam1/sensor.yaml"})
        tiny.write(camera, tiny.read(camera) + kFlat);
    tiny.write("dive.json", R"({"water": {"temperature_c": 4, "salinity_psu": 0}})");
    const auto lake = Dive::open(tiny.folder(), folder / "scratch");
    tiny.write("dive.json", R"({"water": {"temperature_c": 4}})");
    const auto unknown = Dive::open(tiny.folder(), folder / "scratch");

    ASSERT_TRUE(lake->rig().cam1.port);
    EXPECT_EQ(lake->rig().cam1.port->water_index, camera::water_index(4.0, 0.0));
    EXPECT_THAT(lake->findings(),
                testing::Not(HasFinding(Severity::Warning, "water_not_stated", "dive.json")));
    EXPECT_THAT(unknown->findings(),
                HasFinding(Severity::Warning, "water_not_stated", "dive.json"));
    EXPECT_NEAR(unknown->rig().cam1.port->water_index, 1.3425, 0.001);
    // The rays in the water nearly meet behind the lens.
    EXPECT_NEAR(lake->rig().cam0.port->p_lens_cam.z(), 0.01, 0.005);
}

TEST(PortYamlTest, ThePortOfTheDiveIsBeforeCamerasThatStateNone) {
    const TemporaryFolder folder;
    const TinyDive tiny(folder / "dive");
    tiny.write("mav0/cam0/sensor.yaml", tiny.read("mav0/cam0/sensor.yaml") + kFlat);
    const auto with = [&](const std::string& port) {
        tiny.write("dive.json",
                   R"({"water": {"temperature_c": 4, "salinity_psu": 0}, "port": )" + port + "}");
        return Dive::open(tiny.folder(), folder / "scratch");
    };
    const auto good = with(
        R"({"type": "dome", "centre_m": [0, 0, 0], "radius_m": 0.06, "thickness_m": 0.005,
            "glass_index": 1.52})");
    const auto no_object = with("7");
    const auto incomplete = with(R"({"type": "dome"})");

    ASSERT_TRUE(good->rig().cam0.port && good->rig().cam1.port);
    EXPECT_EQ(good->rig().cam0.port->shape, Port::Shape::Flat);
    EXPECT_EQ(good->rig().cam1.port->shape, Port::Shape::Dome);
    EXPECT_EQ(good->rig().cam1.port->radius_m, 0.06);
    for (const auto* dive : {&no_object, &incomplete})
        EXPECT_THAT((*dive)->findings(),
                    HasFinding(Severity::Error, "calibration_port", "dive.json"));
}

}  // namespace
}  // namespace divemesh::dive
