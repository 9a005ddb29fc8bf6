#include "worker/reef/unknown_vertical.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/worker/reef/sheets.hpp"
#include "worker/reef/measure_areas.hpp"

namespace divemesh::reef {
namespace {

using nlohmann::json;

double ramp(double x, double) { return 0.1 + 0.5 * x; }

MeasureOptions without_vertical() {
    MeasureOptions options;
    options.num_replicates = 8;
    options.vertical_is_known = false;
    return options;
}

Area line(const std::string& name) {
    Area area;
    area.name = name;
    area.kind = AreaKind::Transect;
    area.points = {{0.1, 0.25, 0.2}, {0.4, 0.25, 0.2}};
    return area;
}

TEST(UnknownVertical, RefusesWhatDependsOnItAndNamesTheRemedy) {
    AreaSet set{AreaFrame::World, {quadrat("q", 0.1, 0.4), line("t")}};
    const json measured = measure_areas(sheet(0.5, 0.01, ramp), set, without_vertical());
    const auto reason = [&](const char* area, const char* metric, double resolution_m = 0.0) {
        const json entry = metric_of(measured, area, metric, resolution_m);
        EXPECT_FALSE(entry.contains("value")) << metric;
        return entry.value("refused", "");
    };
    for (const char* metric : {"planar_area", "surface_area", "height_range", "slope"})
        EXPECT_NE(reason("whole model", metric).find("record an IMU"), std::string::npos) << metric;
    EXPECT_NE(reason("q", "slope").find("which way is up"), std::string::npos);
    EXPECT_NE(reason("q", "aspect").find("which way is up"), std::string::npos);
    EXPECT_NE(reason("t", "chain_rugosity", 0.05).find("which way is up"), std::string::npos);
    EXPECT_FALSE(measured["areas"][0].contains("planar_area_m2"));
}

TEST(UnknownVertical, AreasWhosePlaneIsGivenAreMeasured) {
    AreaSet set{AreaFrame::World, {quadrat("q", 0.1, 0.4), line("t")}};
    set.areas[1].normal = Eigen::Vector3d::UnitZ();
    const json measured = measure_areas(sheet(0.5, 0.01, ramp), set, without_vertical());
    EXPECT_NEAR(metric_of(measured, "q", "planar_area")["value"].get<double>(), 0.09, 1e-6);
    EXPECT_NEAR(metric_of(measured, "q", "surface_area")["value"].get<double>(),
                0.09 * std::sqrt(1.25),
                1e-5);
    EXPECT_NEAR(metric_of(measured, "t", "chain_rugosity", 0.05)["value"].get<double>(),
                std::sqrt(1.25),
                1e-3);
}

TEST(UnknownVertical, ColoniesAreNotCountedOverTheWholeModel) {
    AreaSet set{AreaFrame::World, {quadrat("colony", 0.1, 0.2)}};
    set.areas[0].label = "Porites";
    const json measured = measure_areas(sheet(0.5, 0.01, ramp), set, without_vertical());
    EXPECT_TRUE(metric_of(measured, "whole model", "population_density").contains("refused"));
    EXPECT_TRUE(metric_of(measured, "whole model", "cover").contains("refused"));
    const json area = metric_of(measured, "whole model", "colony_area_median");
    const json diameter = metric_of(measured, "whole model", "colony_diameter_median");
    EXPECT_NEAR(area.value("value", 0.0), 0.01, 1e-9) << "in the plane of its corners";
    EXPECT_NEAR(diameter.value("value", 0.0), 0.1 * std::sqrt(2.0), 1e-9);
}

// A bed that hangs upside down in its world: the cameras are below it.
TEST(UnknownVertical, CornersAreSeenFromTheSideOfTheNearestCamera) {
    const std::vector<Eigen::Vector3d> cameras = {{0.2, 0.2, -1.0}, {0.2, 0.2, 9.0}};
    const AreaSet set = facing_cameras({AreaFrame::World, {quadrat("q", 0.1, 0.4)}}, cameras);
    ASSERT_TRUE(set.areas[0].normal);
    EXPECT_TRUE(set.areas[0].normal->isApprox(-Eigen::Vector3d::UnitZ()));
    EXPECT_TRUE(facing_cameras(set, {{0.2, 0.2, 1.0}}).areas[0].normal->z() < 0.0) << "as given";
}

}  // namespace
}  // namespace divemesh::reef
