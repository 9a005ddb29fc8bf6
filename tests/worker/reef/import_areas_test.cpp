#include "worker/reef/import_areas.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <numbers>

#include "schemas/error.hpp"
#include "tests/temporary_folder.hpp"
#include "tests/worker/reef/shapefile_bytes.hpp"
#include "tests/worker/reef/sheets.hpp"
#include "worker/io/ply.hpp"
#include "worker/reef/area_plane.hpp"
#include "worker/reef/area_set.hpp"

namespace divemesh::reef {
namespace {

using nlohmann::json;

constexpr double kLatitude_deg = 17.5;
constexpr double kLongitude_deg = -87.75;  // zone 16, 45 arc minutes west of its middle

// A result of a slope of 1 m x 1 m, whose height is a fifth of x.
class ImportAreasTest : public testing::Test {
protected:
    ImportAreasTest() {
        io::write_ply(folder_ / "mesh.ply",
                      sheet(1.0, 0.01, [](double x, double) { return 0.2 * x; }));
        write("metrics.json", "{}");
        write(
            "mosaic.json",
            R"({"pixel_m": 0.02, "width_px": 50, "height_px": 25, "corner_x_m": 0, "corner_y_m": 0.8,
              "geotiff": {"pixel_m": 0.01, "width_px": 100, "height_px": 50, "corner_x_m": 0,
                          "corner_y_m": 0.8}})");
    }
    void write(const std::string& name, const std::string& text) const {
        std::ofstream(folder_ / name, std::ios::binary) << text;
    }
    void give_position() const {
        write("metrics.json",
              json{{"dive",
                    {{"position",
                      {{"latitude_deg", kLatitude_deg},
                       {"longitude_deg", kLongitude_deg},
                       {"x_azimuth_deg", 90.0}}}}}}
                  .dump());
    }
    AreaSet import(const std::string& file, const AreaImport& how = {}) const {
        return parse_areas(
            import_areas(folder_ / file, io::ReconstructionFolder(folder_.path()), how));
    }
    std::string refusal(const std::string& file, const AreaImport& how = {}) const {
        try {
            import(file, how);
        } catch (const Error& error) {
            return error.what();
        }
        return "";
    }
    static json feature(const std::string& type, json coordinates, json properties) {
        return {{"type", "Feature"},
                {"properties", std::move(properties)},
                {"geometry", {{"type", type}, {"coordinates", std::move(coordinates)}}}};
    }
    static json square(double x, double y, double side) {
        return {{x, y}, {x + side, y}, {x + side, y + side}, {x, y + side}, {x, y}};
    }
    void write_geojson(const std::vector<json>& features) const {
        write("a.geojson", json{{"type", "FeatureCollection"}, {"features", features}}.dump());
    }
    static void expect_xy(const Eigen::Vector3d& point, double x, double y, double tolerance_m) {
        EXPECT_NEAR(point.x(), x, tolerance_m);
        EXPECT_NEAR(point.y(), y, tolerance_m);
        EXPECT_NEAR(point.z(), 0.2 * point.x(), 0.2 * 0.005);
    }

    TemporaryFolder folder_;
    const AreaImport world_{.crs = "world", .name_column = "", .label_column = "", .map = ""};
};

TEST_F(ImportAreasTest, FeaturesBecomeAreasOnTheSurfaceWithNamesAndLabels) {
    write_geojson(
        {feature("Polygon", {square(0.2, 0.3, 0.4)}, {{"Name", "q"}, {"kind", "quadrat"}}),
         feature("Polygon", {square(0.1, 0.1, 0.1)}, {{"name", "q"}, {"Species", "P"}}),
         feature("LineString", {{0.1, 0.1}, {0.9, 0.1}}, {{"id", 7}}),
         feature("Point", {0.1, 0.1}, nullptr),
         feature("MultiPolygon", {{square(0, 0, 0.1)}, {square(0.5, 0.5, 0.1)}}, nullptr)});
    const AreaSet set = import("a.geojson", world_);
    ASSERT_EQ(set.areas.size(), 5U);
    EXPECT_EQ(set.areas[0].kind, AreaKind::Quadrat);
    ASSERT_EQ(set.areas[0].points.size(), 4U);
    expect_xy(set.areas[0].points[2], 0.6, 0.7, 1e-9);
    EXPECT_EQ(set.areas[1].name, "q (2)");
    EXPECT_EQ(set.areas[1].label, "P");
    EXPECT_EQ(set.areas[1].kind, AreaKind::Outline);
    EXPECT_EQ(set.areas[2].kind, AreaKind::Transect);
    EXPECT_EQ(set.areas[2].name, "7");
    EXPECT_EQ(set.areas[3].name, "area 5");
    EXPECT_EQ(set.areas[4].name, "area 5 (2)");
}

TEST_F(ImportAreasTest, ColumnsCanBeChosen) {
    write_geojson({feature("Polygon", {square(0, 0, 0.1)}, {{"a", "n"}, {"b", "l"}})});
    const AreaSet set =
        import("a.geojson", {.crs = "world", .name_column = "A", .label_column = "b", .map = ""});
    EXPECT_EQ(set.areas[0].name, "n");
    EXPECT_EQ(set.areas[0].label, "l");
    EXPECT_NE(
        refusal("a.geojson", {.crs = "world", .name_column = "", .label_column = "c", .map = ""})
            .find("no column is called 'c': choose one of a, b"),
        std::string::npos);
}

TEST_F(ImportAreasTest, LongitudeAndLatitudeNeedThePositionOfTheDive) {
    // Lengths of an arc second on the ellipsoid WGS 84: M and N cos(latitude).
    constexpr double kA_m = 6378137.0;
    constexpr double kE2 = 0.00669437999014;
    const double phi = kLatitude_deg * std::numbers::pi / 180.0;
    const double w = 1.0 - kE2 * std::pow(std::sin(phi), 2);
    const double north_m = kA_m * (1.0 - kE2) / std::pow(w, 1.5) * std::numbers::pi / 180.0;
    const double east_m = kA_m / std::sqrt(w) * std::cos(phi) * std::numbers::pi / 180.0;
    json ring = json::array();
    for (const auto& [x, y] : {std::pair{0.2, 0.3}, {0.6, 0.3}, {0.6, 0.7}, {0.2, 0.7}})
        ring.push_back({kLongitude_deg + x / east_m, kLatitude_deg + y / north_m, 0.0});
    write_geojson({feature("Polygon", {ring}, nullptr)});
    EXPECT_NE(refusal("a.geojson").find("the position of the dive is not known"),
              std::string::npos);
    give_position();
    const AreaSet set = import("a.geojson");
    expect_xy(set.areas[0].points[0], 0.2, 0.3, 2e-4);
    expect_xy(set.areas[0].points[2], 0.6, 0.7, 2e-4);
    write_geojson({feature("Polygon", {square(0.2, 0.3, 0.4)}, nullptr)});
    EXPECT_NE(refusal("a.geojson").find("have no place in EPSG:32616"), std::string::npos);
    write_geojson({feature("Polygon", {square(-86.2, 17.3, 0.4)}, nullptr)});
    EXPECT_NE(refusal("a.geojson").find("if its coordinates are longitude and latitude"),
              std::string::npos);
}

TEST_F(ImportAreasTest, WhatCannotBeMeasuredIsRefusedByNameOrReadAsAsked) {
    write_geojson(
        {feature("Polygon", {square(0, 0, 0.5), square(0.1, 0.1, 0.1)}, {{"name", "h"}})});
    EXPECT_NE(refusal("a.geojson", world_).find("area 'h' has 1 holes"), std::string::npos);
    AreaImport filled = world_;
    filled.fill_holes = true;
    EXPECT_NEAR(area_m2(plane_of(import("a.geojson", filled).areas[0]).outline),
                0.25 * std::hypot(1.0, 0.2),
                1e-3);
    write_geojson(
        {feature("Polygon", {{{0, 0}, {0.5, 0.5}, {0.5, 0}, {0, 0.4}}}, {{"name", "bow tie"}})});
    EXPECT_NE(refusal("a.geojson", world_).find("area 'bow tie': its sides cross"),
              std::string::npos);
    write_geojson({feature("Polygon", {square(50, 0, 1)}, nullptr)});
    EXPECT_NE(refusal("a.geojson", world_).find("none of the areas is over the surface"),
              std::string::npos);
    write_geojson({});
    EXPECT_NE(refusal("a.geojson", world_).find("no polygon and no line"), std::string::npos);
    write_geojson({feature("Polygon", {{{0, "x"}}}, nullptr)});
    EXPECT_NE(refusal("a.geojson", world_).find("feature 1: a position is not"), std::string::npos);
    write("a.geojson", R"({"type": "FeatureCollection", "features": [],
        "crs": {"type": "name", "properties": {"name": "urn:ogc:def:crs:EPSG::3857"}}})");
    EXPECT_NE(refusal("a.geojson").find("EPSG::3857' is not read"), std::string::npos);
    write("a.gpkg", "SQLite format 3");
    EXPECT_NE(refusal("a.gpkg").find("save the areas in one of these"), std::string::npos);
}

TEST_F(ImportAreasTest, ContoursOfManyPointsAreSimplified) {
    json ring = json::array();
    for (int i = 0; i < 20'000; ++i) {
        const double angle = 2.0 * std::numbers::pi * i / 20'000.0;
        ring.push_back({0.5 + 0.3 * std::cos(angle), 0.5 + 0.3 * std::sin(angle)});
    }
    write_geojson({feature("Polygon", {ring}, nullptr)});
    const AreaSet set = import("a.geojson", world_);
    EXPECT_LE(set.areas[0].points.size(), kMaxAreaPoints);
    for (const Eigen::Vector3d& point : set.areas[0].points)
        EXPECT_NEAR((point.head<2>() - Eigen::Vector2d(0.5, 0.5)).norm(), 0.3, 1e-4);
    Area flat = set.areas[0];
    flat.normal = Eigen::Vector3d::UnitZ();
    EXPECT_NEAR(area_m2(plane_of(flat).outline), std::numbers::pi * 0.09, 2e-4);
}

TEST_F(ImportAreasTest, AShapefileWithoutAProjectionIsInTheWorld) {
    ShapefileBytes file(15);
    file.add({clockwise_square(0.2, 0.3, 0.4)});
    write("a.shp", file.bytes());
    expect_xy(import("a.shp").areas[0].points[2], 0.6, 0.7, 1e-9);
    write("a.prj", R"(PROJCS["NAD_1927_UTM_Zone_16N",GEOGCS["GCS_North_American_1927")");
    EXPECT_NE(refusal("a.shp").find("its coordinate system (.prj) is not read"), std::string::npos);
    ShapefileBytes broken(5);
    broken.add({{{0, 0}, {std::nan(""), 1}, {1, 1}, {0, 0}}});
    write("b.shp", broken.bytes());
    EXPECT_NE(refusal("b.shp").find("is not finite"), std::string::npos);
}

// What TagLab saves: steps in tenths of a pixel, or lists of points in older versions.
class TagLabAreasTest : public ImportAreasTest {
protected:
    static json region(json contour, const std::string& label) {
        return {{"id", 4},
                {"blob name", "c-4-20.0x-30.0y"},
                {"class name", label},
                {"note", ""},
                {"bbox", {0, 0, 1, 1}},
                {"contour", std::move(contour)},
                {"inner contours", json::array()}};
    }
    static json map(const std::string& name, json annotations) {
        return {{"name", name},
                {"width", 100},
                {"height", 50},
                {"map_px_to_mm_factor", "10"},
                {"annotations", std::move(annotations)}};
    }
    void write_project(const std::vector<json>& maps) const {
        write("p.json",
              json{{"working_area", {10, 20, 50, 30}}, {"labels", json::object()}, {"images", maps}}
                  .dump());
    }
};

TEST_F(TagLabAreasTest, PixelsOfTheMosaicBecomeTheWorld) {
    const std::string steps = "200 300 200 0 0 100 -200 0";  // (20, 30), (40, 30), (40, 40) ...
    write_project(
        {map("2026", {{"regions", {region(steps, "Porites")}}, {"points", json::array()}})});
    const AreaSet set = import("p.json");
    ASSERT_EQ(set.areas.size(), 2U);
    EXPECT_EQ(set.areas[0].label, "Porites");
    EXPECT_EQ(set.areas[0].name, "c-4-20.0x-30.0y");
    expect_xy(set.areas[0].points[0], 0.205, 0.8 - 0.305, 1e-9);
    expect_xy(set.areas[0].points[2], 0.405, 0.8 - 0.405, 1e-9);
    EXPECT_EQ(set.areas[1].name, "working area");
    EXPECT_EQ(set.areas[1].kind, AreaKind::Quadrat);
    expect_xy(set.areas[1].points[0], 0.2, 0.8 - 0.4, 1e-9);
    expect_xy(set.areas[1].points[2], 0.7, 0.8 - 0.1, 1e-9);
    write_project({map("2020", {region({{20, 30}, {40, 30}, {40, 40}}, "Empty")})});
    const AreaSet older = import("p.json");
    EXPECT_EQ(older.areas[0].label, "");
    expect_xy(older.areas[0].points[1], 0.405, 0.8 - 0.305, 1e-9);
}

TEST_F(TagLabAreasTest, AnotherMapThanTheMosaicIsRefused) {
    json other = map("a", {region("200 300 200 0 0 100", "P")});
    other["height"] = 70;
    write_project({other});
    EXPECT_NE(refusal("p.json").find("100 x 70 pixels"), std::string::npos);
    other = map("a", {region("200 300 200 0 0 100", "P")});
    other["map_px_to_mm_factor"] = "4.5";
    write_project({other});
    EXPECT_NE(refusal("p.json").find("it states 4.5 mm a pixel"), std::string::npos);
    other["map_px_to_mm_factor"] = 5;  // the mosaic in twice its resolution
    other["width"] = 200;
    other["height"] = 100;
    write_project({other, map("b", json::array())});
    EXPECT_NE(refusal("p.json").find("of 'a', 'b'"), std::string::npos);
    AreaImport how;
    how.map = "a";
    expect_xy(import("p.json", how).areas[0].points[0], 0.1025, 0.8 - 0.1525, 1e-9);
    write_project({map("a", {region("200 300 200 0 0", "P")})});
    EXPECT_NE(refusal("p.json").find("ends in the middle of a point"), std::string::npos);
    write_project({map("a", {region("200 x", "P")})});
    EXPECT_NE(refusal("p.json").find("not a list of whole numbers"), std::string::npos);
}

// Files that GDAL wrote, in every coordinate system that is read.
class GdalItselfTest : public ImportAreasTest {};

TEST_F(GdalItselfTest, WritesWhatIsRead) {
    if (std::system("command -v ogr2ogr >/dev/null") != 0) GTEST_SKIP() << "there is no ogr2ogr";
    give_position();
    const double x = kLongitude_deg + 2e-6;
    const double y = kLatitude_deg + 3e-6;
    write_geojson(
        {feature("Polygon", {square(x, y, 4e-6)}, {{"name", "q1"}, {"label", "Porit\u00e9s"}}),
         feature("MultiPolygon",
                 {{square(x, y, 1e-6)}, {square(x + 2e-6, y, 1e-6)}},
                 {{"name", "m"}, {"label", nullptr}})});
    const AreaSet truth = import("a.geojson");
    ASSERT_EQ(truth.areas.size(), 3U);
    const std::string from = " '" + (folder_ / "a.geojson").string() + "' 2>/dev/null";
    for (const char* command : {"-f GeoJSON -t_srs EPSG:32616 ",
                                "-f GeoJSON ",
                                "-t_srs EPSG:32616 ",
                                "-t_srs EPSG:32615 ",
                                "-dim XYZ "}) {
        const std::string name =
            std::string("b") + (std::string(command).starts_with("-f") ? ".json" : ".shp");
        const std::string to = "'" + (folder_ / name).string() + "'";
        ASSERT_EQ(std::system(("rm -f '" + (folder_ / "b").string() + "'.*; ogr2ogr " +
                               std::string(command) + "-lco COORDINATE_PRECISION=12 " + to + from)
                                  .c_str()),
                  0)
            << command;
        const AreaSet read = import(name);
        ASSERT_EQ(read.areas.size(), 3U) << command;
        EXPECT_EQ(read.areas[0].name, "q1");
        EXPECT_EQ(read.areas[0].label, "Porit\u00e9s") << command;
        for (std::size_t i = 0; i < 3; ++i) {
            Area area = read.areas[i];
            Area same = truth.areas[i];
            area.normal = same.normal = Eigen::Vector3d::UnitZ();
            EXPECT_NEAR(area_m2(plane_of(area).outline), area_m2(plane_of(same).outline), 1e-4);
            double nearest_m = 1e9;  // of the true first corner, as rings may start anywhere
            for (const Eigen::Vector3d& point : area.points)
                nearest_m = std::min(nearest_m, (point - same.points[0]).norm());
            EXPECT_LT(nearest_m, 1e-4) << command << i;
        }
    }
}

}  // namespace
}  // namespace divemesh::reef
