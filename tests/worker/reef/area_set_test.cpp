#include "worker/reef/area_set.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "schemas/error.hpp"
#include "worker/reef/area_plane.hpp"

namespace divemesh::reef {
namespace {

using nlohmann::json;

json one(json area) { return {{"areas", json::array({std::move(area)})}}; }

json square() {
    return {{"name", "q1"}, {"corners", {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}}};
}

std::string refusal(const json& document) {
    try {
        parse_areas(document);
    } catch (const Error& error) {
        EXPECT_EQ(error.code(), ErrorCode::BadData);
        return error.what();
    }
    return "";
}

TEST(AreaSet, CornersMakeAQuadratAndItsNormalPointsUp) {
    json area = square();
    std::reverse(area["corners"].begin(), area["corners"].end());
    const AreaSet set = parse_areas(one(area));
    EXPECT_EQ(set.frame, AreaFrame::World);
    EXPECT_EQ(set.areas.at(0).kind, AreaKind::Quadrat);
    EXPECT_NEAR(area_m2(plane_of(set.areas[0]).outline), 1.0, 1e-12);
    EXPECT_GT(upward_normal(set.areas[0].points).z(), 0.99);
}

TEST(AreaSet, WhatIsWrongIsSaidWithTheAreasName) {
    json crossing = square();
    std::swap(crossing["corners"][0], crossing["corners"][1]);
    EXPECT_NE(refusal(one(crossing)).find("area 'q1' has no area"), std::string::npos);
    crossing["normal"] = {0, 0, 1};
    EXPECT_NE(refusal(one(crossing)).find("area 'q1': its sides cross"), std::string::npos);
    json few = square();
    few["corners"].erase(0);
    few["corners"].erase(0);
    EXPECT_NE(refusal(one(few)).find("area 'q1': it needs at least three points"),
              std::string::npos);
    json flat = square();
    flat["corners"] = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}};
    EXPECT_NE(refusal(one(flat)).find("area 'q1' has no area"), std::string::npos);
    json edge_on = square();
    edge_on["normal"] = {1, 0, 0};
    EXPECT_NE(refusal(one(edge_on)).find("area 'q1'"), std::string::npos);
}

TEST(AreaSet, WhatIsNoNumberIsRefused) {
    json area = square();
    area["corners"][2][1] = std::numeric_limits<double>::quiet_NaN();
    EXPECT_NE(refusal(one(area)).find("not finite"), std::string::npos);
    area["corners"][2][1] = 1e300;
    EXPECT_NE(refusal(one(area)).find("beyond 100 km"), std::string::npos);
    area["corners"][2][1] = nullptr;
    EXPECT_NE(refusal(one(area)).find("not a number"), std::string::npos);
    area["corners"][2] = {1, 2};
    EXPECT_NE(refusal(one(area)).find("not [x, y, z]"), std::string::npos);
}

TEST(AreaSet, HugeCountsAreRefusedBeforeTheyAreWorkedOn) {
    json area = square();
    area["polygon"] = std::move(area["corners"]);
    area.erase("corners");
    for (int i = 0; i < 1000; ++i) area["polygon"].push_back({i, i * i, 0});
    EXPECT_NE(refusal(one(area)).find("more than 1000 points"), std::string::npos);
    json many = {{"areas", json::array()}};
    for (int i = 0; i <= 10'000; ++i) many["areas"].push_back(nullptr);
    EXPECT_NE(refusal(many).find("more than 10000 areas"), std::string::npos);
}

TEST(AreaSet, ATransectLongerThanAnyDiveIsRefused) {
    const json line = {{"name", "t"}, {"kind", "transect"}, {"line", {{0, 0, 0}, {1.1e4, 0, 0}}}};
    EXPECT_NE(refusal(one(line)).find("area 't': the transect is longer than 10 km"),
              std::string::npos);
}

TEST(AreaSet, AnythingElseThatIsNotAnAreaIsRefused) {
    EXPECT_NE(refusal(json::array()), "");
    EXPECT_NE(refusal({{"areas", 3}}), "");
    EXPECT_NE(refusal(one(7)), "");
    EXPECT_NE(refusal(one({{"name", "x"}})), "");
    EXPECT_NE(refusal({{"areas", {square(), square()}}}).find("twice"), std::string::npos);
    json kind = square();
    kind["kind"] = "circle";
    EXPECT_NE(refusal(one(kind)).find("'circle'"), std::string::npos);
    json frame = one(square());
    frame["frame"] = "moon";
    EXPECT_NE(refusal(frame).find("'moon'"), std::string::npos);
    json line = square();
    line["kind"] = "transect";
    line["corners"] = {{0, 0, 0}, {0, 0, 1}};
    EXPECT_NE(refusal(one(line)).find("above each other"), std::string::npos);
}

TEST(AreaSet, MovingKeepsTheGroundBelowTheAreas) {
    json document = one(square());
    document["frame"] = "ground_truth";
    Eigen::Isometry3d T_world_truth = Eigen::Isometry3d::Identity();
    T_world_truth.rotate(Eigen::AngleAxisd(0.4, Eigen::Vector3d(1, 2, 3).normalized()));
    T_world_truth.translation() = Eigen::Vector3d(5, -2, 1);
    const AreaSet set = moved(parse_areas(document), T_world_truth);
    EXPECT_EQ(set.frame, AreaFrame::World);
    EXPECT_TRUE(set.areas[0].points[2].isApprox(T_world_truth * Eigen::Vector3d(1, 1, 0), 1e-12));
    EXPECT_NEAR(area_m2(plane_of(set.areas[0]).outline), 1.0, 1e-12);
}

}  // namespace
}  // namespace divemesh::reef
