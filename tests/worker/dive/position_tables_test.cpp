#include "worker/dive/position_tables.hpp"

#include <gtest/gtest.h>

#include <algorithm>

namespace divemesh::dive {
namespace {

constexpr int kUtm20N = 32620;

std::vector<Finding> told_of_points(const std::string& text) {
    FindingLog findings;
    types::OutsidePositions outside;
    parse_control_points(text, outside, findings);
    return findings.all();
}

SensorYaml yaml(const std::string& kind, std::optional<double> epsg) {
    SensorYaml yaml;
    yaml.position_kind = kind;
    yaml.epsg = epsg;
    return yaml;
}

TEST(PositionTablesTest, LatitudeAndLongitudeBecomeTheUtmOfTheirPlace) {
    FindingLog findings;
    types::OutsidePositions outside;
    outside.sources.push_back({.name = "position0", .epsg = 4326});
    // On a central meridian: 0.9996 times the meridian's arc to 45 degrees, 4,984,944.378 m on
    // WGS 84.
    outside.sources[0].samples = parse_positions(
        "1000000000,45.0,3.0,33.0,2.0,5.0\n", 4326, "mav0/position0/data.csv", findings);
    ASSERT_EQ(outside.sources[0].samples.size(), 1U);
    to_common_system(outside, findings);
    EXPECT_TRUE(findings.all().empty());
    EXPECT_EQ(outside.utm_epsg, 32631);
    EXPECT_NEAR(outside.sources[0].samples[0].utm_m.x(), 500000.0, 1e-3);
    EXPECT_NEAR(outside.sources[0].samples[0].utm_m.y(), 4982950.400, 2e-3);
    EXPECT_DOUBLE_EQ(outside.sources[0].samples[0].utm_m.z(), 33.0);
}

TEST(PositionTablesTest, ExchangedLatitudeAndLongitudeOutOfRangeAreRefusedWithTheLine) {
    FindingLog findings;
    const auto samples = parse_positions(
        "#t,lat,lon,alt,sh,sv\n1000000000,-120.5,44.6,0,1,0\n2000000000,-120.5,44.6,0,1,0\n",
        4326,
        "data.csv",
        findings);
    EXPECT_TRUE(samples.empty());
    ASSERT_FALSE(findings.all().empty());
    EXPECT_EQ(findings.all()[0].severity, Severity::Error);
    EXPECT_NE(findings.all()[0].where.find("2"), std::string::npos) << findings.all()[0].where;
}

TEST(PositionTablesTest, ARowNeedsASigmaThatSaysSomething) {
    for (const char* sigmas : {"0,0", "-1,0", "nan,1", "1,-2", "1e6,0", "1"}) {
        FindingLog findings;
        const std::string row = "1000000000,500000,1460000,0," + std::string(sigmas) + "\n";
        EXPECT_TRUE(parse_positions(row, kUtm20N, "data.csv", findings).empty()) << sigmas;
        EXPECT_FALSE(findings.all().empty()) << sigmas;
    }
}

TEST(PositionTablesTest, ACoordinateSystemIsNeverAssumed) {
    for (const auto& given : {std::optional<double>(),
                              std::optional(25832.0),
                              std::optional(32661.0),
                              std::optional(4326.5),
                              std::optional(1e300)}) {
        FindingLog findings;
        EXPECT_FALSE(describe_source("position0", yaml("usbl", given), "sensor.yaml", findings));
        EXPECT_EQ(findings.all().at(0).severity, Severity::Error);
    }
    FindingLog findings;
    EXPECT_FALSE(describe_source("position0", yaml("sonar", kUtm20N), "sensor.yaml", findings));
    EXPECT_TRUE(describe_source("position0", yaml("usbl", kUtm20N), "sensor.yaml", findings));
}

TEST(PositionTablesTest, OnlyAFloatHasAnOffsetThatIsNotStated) {
    FindingLog findings;
    EXPECT_GT(describe_source("position0", yaml("gps_float", 4326), "f", findings)->offset_sigma_m,
              0.0);
    EXPECT_EQ(describe_source("position0", yaml("usbl", 4326), "f", findings)->offset_sigma_m, 0.0);
}

TEST(PositionTablesTest, WrongControlPointsAreErrorsThatNameThem) {
    const std::string good =
        R"({"name": "A", "marker_id": 3, "position": [500000, 1460000, -7], "sigma_h_m": 0.02, "sigma_v_m": 0.03})";
    EXPECT_TRUE(told_of_points(R"({"epsg": 32620, "points": [)" + good + "]}").empty());
    for (
        const std::string& points :
        {good + "," + good,
         std::string(
             R"({"name": "A", "marker_id": 3, "position": [500000, 1460000, -7], "sigma_h_m": 0.02})"),
         std::string(
             R"({"name": "A", "marker_id": "3", "position": [500000, 1460000], "sigma_h_m": 0.02})"),
         std::string(R"({"name": "A", "marker_id": 3, "position": [500000], "sigma_h_m": 0.02})"),
         std::string("7")}) {
        const auto told = told_of_points(R"({"epsg": 32620, "points": [)" + points + "]}");
        ASSERT_EQ(told.size(), 1U) << points;
        EXPECT_EQ(told[0].code, "control_points_unreadable");
        EXPECT_NE(told[0].where.find("#/points/"), std::string::npos);
    }
    for (const char* text :
         {"", "[]", "{}", R"({"points": []})", R"({"epsg": 25832, "points": []})"})
        EXPECT_EQ(told_of_points(text).size(), 1U) << text;
}

TEST(PositionTablesTest, PlacesOfOtherContinentsAreNotProjectedIntoOneZone) {
    FindingLog findings;
    types::OutsidePositions outside;
    outside.sources.push_back({.name = "position0", .epsg = kUtm20N});
    outside.sources[0].samples.push_back({1, {500000.0, 1460000.0, 0.0}, 1.0, 0.0});
    outside.sources.push_back({.name = "position1", .epsg = 4326});
    outside.sources[1].samples.push_back({1, {-40.0, 117.0, 0.0}, 1.0, 0.0});
    to_common_system(outside, findings);
    const bool told = std::ranges::any_of(
        findings.all(), [](const Finding& finding) { return finding.severity == Severity::Error; });
    EXPECT_TRUE(told || outside.sources[1].samples[0].utm_m.norm() > 1e6);
}

TEST(PositionTablesTest, VelocitiesOfNoInstrumentAreRefused) {
    FindingLog findings;
    EXPECT_EQ(parse_velocities("1000000000,0.1,0,0,0.01\n", "data.csv", findings).size(), 1U);
    EXPECT_TRUE(findings.all().empty());
    EXPECT_TRUE(parse_velocities("1000000000,100,0,0,0.01\n", "data.csv", findings).empty());
    EXPECT_FALSE(findings.all().empty());
}

}  // namespace
}  // namespace divemesh::dive
