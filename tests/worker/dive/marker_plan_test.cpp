#include "worker/dive/marker_plan.hpp"

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "schemas/invalid_input.hpp"

namespace divemesh::dive {
namespace {

using nlohmann::json;
using testing::HasSubstr;

std::vector<Fault> faults_of(const json& document) {
    try {
        marker_plan_from_json(document);
    } catch (const InvalidInput& wrong) {
        return wrong.faults();
    }
    return {};
}

const json kWhole = json::parse(R"({
    "family": "tag36h11", "size_m": 0.12, "size_sigma_m": 0.0002, "sizes_m": {"7": 0.08},
    "scale_bars": [
        {"name": "north", "from": 1, "to": 2, "distance_m": 0.5, "sigma_m": 0.0005},
        {"from": {"id": 3, "corner": "top_left"}, "to": 3, "distance_m": 0.085}]})");

TEST(MarkerPlanTest, ReadsWhatADiveSays) {
    const MarkerPlan plan = marker_plan_from_json(kWhole);

    EXPECT_EQ(plan.family, MarkerFamily::Tag36h11);
    EXPECT_EQ(plan.size_of(1), 0.12);
    EXPECT_EQ(plan.size_of(7), 0.08);
    ASSERT_EQ(plan.scale_bars.size(), 2U);
    EXPECT_EQ(plan.scale_bars[0].sigma_m, 0.0005);
    EXPECT_EQ(plan.scale_bars[1].from.corner, TagCorner::TopLeft);
    EXPECT_EQ(plan.scale_bars[1].name, "3 top_left - 3");
    EXPECT_TRUE(plan.names(2));
    EXPECT_FALSE(plan.names(9));
}

TEST(MarkerPlanTest, IsWrittenAsItIsRead) {
    const MarkerPlan plan = marker_plan_from_json(kWhole);

    EXPECT_EQ(to_json(marker_plan_from_json(to_json(plan))), to_json(plan));
}

TEST(MarkerPlanTest, RefusesEveryFieldByItsName) {
    const auto faults = faults_of(json::parse(R"({
        "family": "tag36h11", "size_m": -1, "sizes_m": {"x": 1, "600": 1, "4": "big"}, "colour": 1,
        "scale_bars": [{"from": 1, "to": 1, "distance_m": 1},
                       {"from": {"id": 2, "corner": "middle"}, "to": 587, "distance_m": 1e9},
                       {"name": "", "from": -1, "to": 3.5, "distance_m": 1, "sigma_m": -1}, 7]})"));

    std::string all;
    for (const Fault& fault : faults) all += fault.detail + "\n";
    for (const char* field : {"field size_m ",
                              "field sizes_m.x ",
                              "field sizes_m.600 ",
                              "field sizes_m.4 ",
                              "field colour is unknown",
                              "field scale_bars[0].to ",
                              "field scale_bars[1].from ",
                              "field scale_bars[1].to ",
                              "field scale_bars[1].distance_m ",
                              "field scale_bars[2].name ",
                              "field scale_bars[2].from ",
                              "field scale_bars[2].to ",
                              "field scale_bars[2].sigma_m ",
                              "field scale_bars[3] "})
        EXPECT_THAT(all, HasSubstr(field));
}

TEST(MarkerPlanTest, AFamilyIsNamedOrRefused) {
    EXPECT_THAT(faults_of(json::object())[0].detail, HasSubstr("field family must name one of"));
    EXPECT_THAT(faults_of({{"family", "aruco"}})[0].detail, HasSubstr("tagStandard41h12"));
    EXPECT_THAT(faults_of(json::array())[0].detail, HasSubstr("not a JSON object"));
    EXPECT_TRUE(faults_of({{"family", "41h12"}}).size() == 1);
    EXPECT_TRUE(faults_of({{"family", "Standard41h12"}}).empty());
}

TEST(MarkerPlanTest, ThereIsNoPlanUnlessDiveOrOptionsNameAFamily) {
    EXPECT_FALSE(marker_plan_of(std::nullopt, make_options("standard", json::object())));
    EXPECT_FALSE(marker_plan_of(std::nullopt, make_options("standard", {{"marker_size_m", 0.1}})));
}

TEST(MarkerPlanTest, OptionsOverrideTheDive) {
    const MarkerPlan dive = marker_plan_from_json(kWhole);
    const auto options =
        make_options("standard", {{"marker_family", "tag25h9"}, {"marker_size_m", 0.2}});

    const auto plan = marker_plan_of(dive, options);

    ASSERT_TRUE(plan);
    EXPECT_EQ(plan->family, MarkerFamily::Tag25h9);
    EXPECT_EQ(plan->size_of(7), 0.2);
    EXPECT_EQ(plan->scale_bars.size(), 2U);
}

}  // namespace
}  // namespace divemesh::dive
