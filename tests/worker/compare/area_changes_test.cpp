#include "worker/compare/area_changes.hpp"

#include <gtest/gtest.h>

#include <fstream>
#include <memory>
#include <numbers>
#include <valijson/adapters/nlohmann_json_adapter.hpp>
#include <valijson/schema.hpp>
#include <valijson/schema_parser.hpp>
#include <valijson/validator.hpp>

#include "schemas/error.hpp"
#include "tests/paths.hpp"
#include "tests/synthetic/rough_ground.hpp"
#include "tests/synthetic/small_reconstruction.hpp"
#include "tests/temporary_folder.hpp"
#include "worker/compare/compare.hpp"

namespace divemesh::compare {
namespace {

using nlohmann::json;
using synthetic::cone;
using synthetic::ground_mesh;

constexpr double kRadius_m = 0.25;
constexpr double kHeight_m = 0.2;
constexpr double kVolume_m3 = std::numbers::pi * kRadius_m * kRadius_m * kHeight_m / 3.0;

// Returns an outline around a cone, slightly wider; given in the earlier frame and mapped by T into
// another.
json outline(const std::string& name, double x, double y, const Eigen::Isometry3d& T) {
    json corners = json::array();
    for (int i = 0; i < 24; ++i) {
        const double heading = 2.0 * std::numbers::pi * i / 24.0;
        const Eigen::Vector3d p =
            T * Eigen::Vector3d(x + 0.28 * std::cos(heading), y + 0.28 * std::sin(heading), 0.0);
        corners.push_back({p.x(), p.y(), p.z()});
    }
    return {{"name", name}, {"label", "Porites"}, {"polygon", corners}};
}

// Three cones stand, one of them disappears and two are added; all have the same label.
class AreaChangesTest : public testing::Test {
protected:
    static void SetUpTestSuite() {
        folder_ = std::make_unique<TemporaryFolder>();
        make_dives();
        both_years_ = compare(true);
    }
    static void TearDownTestSuite() { folder_.reset(); }

    static void make_dives() {
        const auto ground = synthetic::rough_ground(8);
        const auto with = [&](std::vector<Eigen::Vector2d> places) {
            return [ground, places](double x, double y) {
                double height = ground(x, y);
                for (const Eigen::Vector2d& p : places)
                    height += cone(x - p.x(), y - p.y(), kRadius_m, kHeight_m);
                return height;
            };
        };
        T_.linear() = Eigen::AngleAxisd(1.2, Eigen::Vector3d::UnitZ()).toRotationMatrix();
        T_.translation() = Eigen::Vector3d(2.0, 1.0, -0.4);
        synthetic::write_reconstruction(
            *folder_ / "a", ground_mesh(with({stays1_, stays2_, goes_}), 1.6, 1.2, 0.02, 0.002, 1));
        synthetic::write_reconstruction(
            *folder_ / "b",
            synthetic::moved(
                ground_mesh(with({stays1_, stays2_, new1_, new2_}), 1.6, 1.2, 0.02, 0.002, 2), T_));
        const Eigen::Isometry3d same = Eigen::Isometry3d::Identity();
        write("earlier.json",
              {outline("a1", stays1_.x(), stays1_.y(), same),
               outline("a2", stays2_.x(), stays2_.y(), same),
               outline("a3", goes_.x(), goes_.y(), same),
               outline("beside", 9.0, 9.0, same)});
        write("later.json",
              {outline("b1", stays1_.x(), stays1_.y(), T_),
               outline("b2", stays2_.x(), stays2_.y(), T_),
               outline("b4", new1_.x(), new1_.y(), T_),
               outline("b5", new2_.x(), new2_.y(), T_)});
    }

    static void write(const char* name, const json& areas) {
        std::ofstream(*folder_ / name) << json{{"areas", areas}};
    }
    static json compare(bool with_later) {
        CompareRequest request{.a = *folder_ / "a",
                               .b = *folder_ / "b",
                               .out = *folder_ / (with_later ? "out" : "one_year"),
                               .areas = *folder_ / "earlier.json"};
        if (with_later) request.later_areas = *folder_ / "later.json";
        return compare_reconstructions(request);
    }

    static inline std::unique_ptr<TemporaryFolder> folder_;
    static inline json both_years_;
    static inline Eigen::Isometry3d T_ = Eigen::Isometry3d::Identity();
    static inline const Eigen::Vector2d stays1_{0.0, 0.1};
    static inline const Eigen::Vector2d stays2_{1.2, -0.7};
    static inline const Eigen::Vector2d goes_{-0.7, -0.3};
    static inline const Eigen::Vector2d new1_{0.7, 0.5};
    static inline const Eigen::Vector2d new2_{-1.1, 0.7};
};

json metric(const json& document, const json& wanted) {
    for (const json& one : document.at("areas").at("figures")) {
        bool is_it = one.contains("area") == wanted.contains("area");
        for (const auto& [key, value] : wanted.items())
            is_it = is_it && one.value(key, json()) == value;
        if (is_it) return one;
    }
    return {};
}

void expect_holds(const json& one, const char* time, double truth) {
    ASSERT_TRUE(one.contains(time)) << one;
    EXPECT_LE(one[time]["low"].get<double>(), truth) << one;
    EXPECT_GE(one[time]["high"].get<double>(), truth) << one;
}

TEST_F(AreaChangesTest, CountsDensityAndCoverOfALabelChangeByWhatCameAndWent) {
    const json& document = both_years_;
    const double surveyed_m2 = document["areas"]["surveyed_m2"];
    EXPECT_NEAR(surveyed_m2, 3.2 * 2.4, 0.25);
    const json count = metric(document, {{"figure", "count"}, {"label", "Porites"}});
    EXPECT_EQ(count["earlier"]["value"], 3);
    EXPECT_EQ(count["later"]["value"], 4);
    EXPECT_EQ(count["change"]["value"], 1);
    const json density = metric(document, {{"figure", "population_density"}});
    EXPECT_NEAR(density["change"]["value"].get<double>(), 1.0 / surveyed_m2, 1e-9);
    const json cover = metric(document, {{"figure", "cover"}});
    const double outline_m2 = 12.0 * 0.28 * 0.28 * std::sin(std::numbers::pi / 12.0);
    EXPECT_NEAR(cover["earlier"]["value"].get<double>(), 3 * outline_m2 / surveyed_m2, 1e-3);
    EXPECT_NEAR(cover["change"]["value"].get<double>(), outline_m2 / surveyed_m2, 1e-3);
    const json median = metric(document, {{"figure", "colony_area_median"}});
    EXPECT_NEAR(median["later"]["value"].get<double>(), outline_m2, 1e-5);
    EXPECT_NEAR(median["change"]["value"].get<double>(), 0.0, 1e-5);
}

TEST_F(AreaChangesTest, VolumesOfOutlinesAndLabelsHoldTheKnownOnes) {
    const json& document = both_years_;
    expect_holds(
        metric(document, {{"figure", "lost_volume"}, {"area", "a3"}}), "change", kVolume_m3);
    expect_holds(
        metric(document, {{"figure", "grown_volume"}, {"area", "b4"}}), "change", kVolume_m3);
    expect_holds(metric(document, {{"figure", "net_volume"}, {"area", "a1"}}), "change", 0.0);
    expect_holds(
        metric(document, {{"figure", "net_volume"}, {"area", "a3"}}), "change", -kVolume_m3);
    expect_holds(metric(document, {{"figure", "grown_volume"}, {"label", "Porites"}}),
                 "change",
                 2.0 * kVolume_m3);
    EXPECT_TRUE(
        metric(document, {{"figure", "net_volume"}, {"area", "beside"}}).contains("refused"));
    EXPECT_EQ(document["areas"]["areas"][0]["same_as"], "b1");
    EXPECT_FALSE(document["areas"]["areas"][2].contains("same_as"));
}

TEST_F(AreaChangesTest, OutlinesOfOneYearGiveVolumesAndRefuseTheChangeOfCounts) {
    const json document = compare(false);
    expect_holds(
        metric(document, {{"figure", "lost_volume"}, {"area", "a3"}}), "change", kVolume_m3);
    const json count = metric(document, {{"figure", "count"}});
    EXPECT_EQ(count["earlier"]["value"], 3);
    EXPECT_TRUE(count.contains("refused"));
    EXPECT_FALSE(count.contains("later"));
}

TEST_F(AreaChangesTest, TheDocumentFitsTheSchemaAndTheTableAndThePageNameEachOutline) {
    const json& document = both_years_;
    const json text =
        json::parse(std::ifstream(source_directory() / "schemas" / "compare.schema.json"));
    valijson::Schema schema;
    valijson::SchemaParser().populateSchema(valijson::adapters::NlohmannJsonAdapter(text), schema);
    valijson::ValidationResults problems;
    EXPECT_TRUE(valijson::Validator().validate(
        schema, valijson::adapters::NlohmannJsonAdapter(document), &problems));
    for (const char* file : {"area_changes.csv", "report.html"}) {
        std::ifstream stream(*folder_ / "out" / file);
        const std::string written{std::istreambuf_iterator<char>(stream), {}};
        for (const char* name : {"a1", "a3", "b5", "Porites"})
            EXPECT_NE(written.find(name), std::string::npos) << file << " " << name;
    }
}

TEST_F(AreaChangesTest, AreasOfAnotherFrameAreRefusedByName) {
    std::ofstream(*folder_ / "truth.json")
        << json{{"frame", "ground_truth"}, {"areas", json::array()}};
    try {
        read_compared_areas(*folder_ / "truth.json", std::nullopt);
        FAIL();
    } catch (const Error& error) {
        EXPECT_EQ(error.code(), ErrorCode::BadData);
        EXPECT_NE(std::string(error.what()).find("truth.json"), std::string::npos);
    }
}

}  // namespace
}  // namespace divemesh::compare
