#include "worker/reef/measure_areas.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "schemas/error.hpp"
#include "tests/worker/reef/sheets.hpp"
#include "worker/reef/area_plane.hpp"
#include "worker/reef/measure_reconstruction.hpp"
#include "worker/reef/surface_noise.hpp"

namespace divemesh::reef {
namespace {

using nlohmann::json;

double hills(double x, double y) { return 0.02 * std::sin(20.0 * x) * std::cos(17.0 * y) + 0.05; }

MeasureOptions few_replicates() {
    MeasureOptions options;
    options.num_replicates = 8;
    return options;
}

AreaSet set_of(std::vector<Area> areas) { return {AreaFrame::World, std::move(areas)}; }

TEST(MeasureAreas, MetricsOfAKnownShapeComeWithUnitResolutionIntervalAndMethod) {
    const types::Mesh mesh = sheet(0.5, 0.01, [](double x, double) { return 0.1 + 0.5 * x; });
    const json measured = measure_areas(mesh, set_of({quadrat("q", 0.1, 0.4)}), {});
    EXPECT_NEAR(metric_of(measured, "q", "planar_area")["value"].get<double>(), 0.09, 1e-6);
    EXPECT_NEAR(metric_of(measured, "q", "surface_area")["value"].get<double>(),
                0.09 * std::sqrt(1.25),
                1e-5);
    EXPECT_NEAR(metric_of(measured, "q", "volume")["value"].get<double>(), 0.09 * 0.225, 1e-5);
    EXPECT_NEAR(metric_of(measured, "q", "height_range")["value"].get<double>(), 0.15, 1e-5);
    EXPECT_NEAR(metric_of(measured, "q", "slope")["value"].get<double>(), 26.565, 1e-2);
    EXPECT_NEAR(metric_of(measured, "q", "aspect")["value"].get<double>(), 270.0, 1e-2);
    EXPECT_NEAR(metric_of(measured, "q", "longest_diameter")["value"].get<double>(),
                0.3 * std::sqrt(2.0),
                1e-6);
    const json rugosity = metric_of(measured, "q", "rugosity", 0.05);
    EXPECT_NEAR(rugosity["value"].get<double>(), std::sqrt(1.25), 1e-4);
    EXPECT_EQ(rugosity["unit"], "");
    EXPECT_FALSE(rugosity["method"].get<std::string>().empty());
    EXPECT_LE(rugosity["low"].get<double>(), rugosity["high"].get<double>());
    EXPECT_NEAR(
        metric_of(measured, "whole model", "planar_area")["value"].get<double>(), 0.25, 0.01);
}

TEST(MeasureAreas, BelowThreeSigmaAndBelowTheDetailMetricsAreRefusedWithTheReason) {
    types::Mesh mesh = sheet(0.4, 0.01, hills);
    mesh.sigma_m.assign(mesh.vertices.size(), 0.005F);
    MeasureOptions options = few_replicates();
    options.min_detail_m = 0.04;
    const json measured = measure_areas(mesh, set_of({quadrat("q", 0.05, 0.35)}), options);
    const auto refused = [&](double resolution_m) {
        return metric_of(measured, "q", "rugosity", resolution_m).value("refused", "");
    };
    EXPECT_NE(refused(0.01).find("3 sigma of the surface, 15.0 mm"), std::string::npos);
    EXPECT_NE(refused(0.02).find("detail of the surface, 40.0 mm"), std::string::npos);
    EXPECT_EQ(refused(0.05), "");
    EXPECT_NEAR(metric_of(measured, "q", "vrm")["resolution_m"].get<double>(), 0.05, 1e-12);
}

TEST(MeasureAreas, AFewVagueVerticesDoNotCoarsenTheRest) {
    const auto measured_if_vague_beyond = [](float x_m) {
        types::Mesh mesh = sheet(0.5, 0.01, hills);
        for (const Eigen::Vector3f& vertex : mesh.vertices)
            mesh.sigma_m.push_back(vertex.x() > x_m ? 0.2F : 0.001F);
        mesh.sigma_local_m.assign(mesh.vertices.size(), 1e-6F);
        return measure_areas(mesh, set_of({quadrat("q", 0.1, 0.4)}), few_replicates());
    };
    const json a_tenth = measured_if_vague_beyond(0.375F);
    EXPECT_NEAR(a_tenth["areas"][1]["sigma_m"].get<double>(), 0.001, 1e-6);
    EXPECT_TRUE(metric_of(a_tenth, "q", "rugosity", 0.01).contains("value"));
    const json a_third = measured_if_vague_beyond(0.305F);
    EXPECT_NEAR(a_third["areas"][1]["sigma_m"].get<double>(), 0.2, 1e-6);
    EXPECT_EQ(metric_of(a_third, "q", "rugosity", 0.10).value("refused", ""),
              "below 3 sigma of the surface, 600.0 mm");
}

TEST(MeasureAreas, NoiseIsTakenBackByItsLocalPartAlone) {
    types::Mesh mesh = sheet(0.4, 0.01, hills);
    const double exact = metric_of(measure_areas(mesh, set_of({quadrat("q", 0.05, 0.35)}), {}),
                                   "q",
                                   "rugosity",
                                   0.05)["value"];
    mesh.sigma_m.assign(mesh.vertices.size(), 0.01F);
    mesh.sigma_local_m.assign(mesh.vertices.size(), 0.0001F);
    const json measured = measure_areas(mesh, set_of({quadrat("q", 0.05, 0.35)}), few_replicates());
    EXPECT_NEAR(
        metric_of(measured, "q", "rugosity", 0.05)["value"].get<double>(), exact, 1e-4 * exact);
    EXPECT_NEAR(measured["areas"][1]["sigma_m"].get<double>(), 0.01, 1e-6);
    EXPECT_LE(measured["areas"][1]["sigma_local_m"].get<double>(), 0.000101);
}

TEST(MeasureAreas, IntervalsIncludeErrorsThatTheWholeSurfaceShares) {
    const types::Mesh mesh = sheet(0.5, 0.01, [](double x, double) { return 0.1 + 0.5 * x; });
    MeasureOptions options;
    options.scale_sigma = 0.01;
    options.sigma_shared_m = 0.002;
    const json measured = measure_areas(mesh, set_of({quadrat("q", 0.1, 0.4)}), options);
    const auto half_width = [&](const char* metric) {
        const json entry = metric_of(measured, "q", metric);
        return 0.5 * (entry["high"].get<double>() - entry["low"].get<double>());
    };
    EXPECT_NEAR(half_width("planar_area"), 1.96 * 0.02 * 0.09, 1e-6);
    EXPECT_NEAR(half_width("longest_diameter"), 1.96 * 0.01 * 0.3 * std::sqrt(2.0), 1e-6);
    EXPECT_NEAR(half_width("volume"), 1.96 * std::hypot(0.002 * 0.09, 0.03 * 0.09 * 0.225), 1e-6);
}

TEST(MeasureAreas, AVolumeIsOverThePlaneAtTheMeanHeightOfTheCorners) {
    const types::Mesh mesh = sheet(0.5, 0.01, [](double, double) { return 0.1; });
    Area area = quadrat("q", 0.1, 0.4);
    area.points[0].z() = area.points[2].z() = 0.06;  // the normal stays upright
    const auto volume_of = [&] {
        return metric_of(measure_areas(mesh, set_of({area}), {}), "q", "volume")["value"]
            .get<double>();
    };
    EXPECT_NEAR(volume_of(), 0.09 * (0.1 - 0.03), 1e-7);
    std::rotate(area.points.begin(), area.points.begin() + 1, area.points.end());
    EXPECT_NEAR(volume_of(), 0.09 * (0.1 - 0.03), 1e-7);  // whichever corner is the first
    area.normal = Eigen::Vector3d::UnitZ();
    area.points[0].z() = 0.08;
    EXPECT_NEAR(volume_of(), 0.09 * (0.1 - 0.05), 1e-7);
}

TEST(MeasureAreas, TheBorderOfWhatWasSeenIsInTheIntervalOfItsArea) {
    types::Mesh mesh = sheet(0.5, 0.01, hills);
    MeasureOptions options = few_replicates();
    options.min_detail_m = 0.02;
    options.scale_sigma = 0.0;
    const json planar = metric_of(measure_areas(mesh, {}, options), "whole model", "planar_area");
    const double sigma = 0.02 * std::sqrt(4.0 * 0.5 * 0.02 / 12.0);
    EXPECT_NEAR(
        planar["high"].get<double>() - planar["value"].get<double>(), 1.96 * sigma, 0.05 * sigma);
}

TEST(MeasureAreas, FlatGroundHasNoFractalDimensionAndSaysWhy) {
    types::Mesh noisy = sheet(0.6, 0.01, [](double, double) { return 0.0; });
    noisy.sigma_m.assign(noisy.vertices.size(), 0.003F);
    const SurfacePatch patch = cut_patch(noisy, plane_of(quadrat("q", 0.0, 0.6)), 0.1);
    const auto moved = with_noise(patch, patch.sigma_local_m, NoiseField(0.02, 4), 1.0);
    for (std::size_t i = 0; i < moved.size(); ++i) noisy.vertices[i] = moved[i].cast<float>();
    noisy.triangles.clear();
    for (const auto& [a, b, c] : patch.triangles) noisy.triangles.push_back({a, b, c});
    const json measured =
        measure_areas(noisy, set_of({quadrat("q", 0.05, 0.55)}), few_replicates());
    for (const char* metric :
         {"fractal_dimension_hvar", "fractal_dimension_cubes", "fractal_dimension_rdh"})
        EXPECT_NE(metric_of(measured, "q", metric).value("refused", "").find("too flat: heights"),
                  std::string::npos)
            << metric;
}

TEST(MeasureAreas, CoarseCamerasMakeCoarseMetrics) {
    const types::Mesh mesh = sheet(0.4, 0.01, hills);
    MeasureOptions options = few_replicates();
    options.focal_px = 500.0;
    options.camera_positions_world = {{0.2, 0.2, 2.05}};
    const json measured = measure_areas(mesh, set_of({quadrat("q", 0.05, 0.35)}), options);
    EXPECT_NEAR(measured["areas"][1]["detail_m"].get<double>(), 15.0 * 2.0 / 500.0, 2e-3);
    EXPECT_TRUE(metric_of(measured, "q", "rugosity", 0.05).contains("refused"));
    EXPECT_TRUE(metric_of(measured, "q", "rugosity", 0.10).contains("value"));
}

TEST(MeasureAreas, WhatWasNotSeenIsStatedAndNothingIsSaidOfTheArea) {
    const types::Mesh mesh = sheet(0.4, 0.01, hills);
    const json measured = measure_areas(
        mesh, set_of({quadrat("edge", 0.2, 0.6), quadrat("outside", 1.0, 1.2)}), few_replicates());
    EXPECT_NEAR(measured["areas"][1]["coverage"].get<double>(), 0.25, 0.01);
    EXPECT_NE(metric_of(measured, "edge", "rugosity", 0.05)["refused"].get<std::string>().find(
                  " % of the area was seen, less than 50 %"),
              std::string::npos);
    EXPECT_EQ(measured["areas"][2]["coverage"], 0.0);
    EXPECT_TRUE(metric_of(measured, "outside", "surface_area").contains("refused"));
}

TEST(MeasureAreas, ThreeQuartersSeenGiveRatiosButNoExtremes) {
    const types::Mesh mesh = sheet(0.4, 0.01, hills);
    Area area = quadrat("q", 0.1, 0.5);
    area.points[2].y() = area.points[3].y() = 0.4;
    const json measured = measure_areas(mesh, set_of({area}), few_replicates());
    EXPECT_TRUE(metric_of(measured, "q", "rugosity", 0.05).contains("value"));
    EXPECT_TRUE(metric_of(measured, "q", "height_range").contains("refused"));
    EXPECT_TRUE(metric_of(measured, "q", "volume").contains("refused"));
}

TEST(MeasureAreas, ATransectIsAsLongAsTheTrianglesBelowIt) {
    const types::Mesh roof =
        sheet(1.0, 0.5, [](double x, double) { return 0.3 - 0.6 * std::abs(x - 0.5); });
    Area line;
    line.name = "t";
    line.kind = AreaKind::Transect;
    line.points = {{0.1, 0.33, 0.0}, {0.52, 0.33, 1.0}, {0.9, 0.33, 0.0}};
    const json measured = measure_areas(roof, set_of({line}), few_replicates());
    EXPECT_NEAR(metric_of(measured, "t", "chain_rugosity", 0.01)["value"].get<double>(),
                std::hypot(1.0, 0.6),
                1e-3);
    EXPECT_NEAR(measured["areas"][1]["length_m"].get<double>(), 0.8, 1e-9);
    EXPECT_EQ(measured["areas"][1]["coverage"], 1.0);
}

TEST(MeasureAreas, LabelsGiveDensityCoverAndSizesOverTheQuadrats) {
    const types::Mesh mesh = sheet(1.0, 0.05, [](double, double) { return 0.0; });
    std::vector<Area> areas = {quadrat("q", 0.0, 0.8)};
    for (int i = 0; i < 5; ++i) {
        areas.push_back(quadrat("colony " + std::to_string(i), 0.1 * i + 0.1, 0.1 * i + 0.15));
        areas.back().label = "Porites";
    }
    areas.back().points = quadrat("", 0.9, 0.95).points;  // outside the quadrat
    const json measured = measure_areas(mesh, set_of(areas), few_replicates());
    const json density = metric_of(measured, "quadrats", "population_density");
    EXPECT_EQ(density["label"], "Porites");
    EXPECT_NEAR(density["value"].get<double>(), 4.0 / 0.64, 1e-6);
    EXPECT_NEAR(
        metric_of(measured, "quadrats", "cover")["value"].get<double>(), 4 * 0.0025 / 0.64, 1e-6);
    EXPECT_NEAR(
        metric_of(measured, "quadrats", "colony_area_median")["value"].get<double>(), 0.0025, 1e-9);
    // All colonies are alike, so only the scale makes their sizes uncertain.
    const json diameter = metric_of(measured, "quadrats", "colony_diameter_median");
    const double diameter_m = 0.05 * std::sqrt(2.0);
    EXPECT_NEAR(diameter["high"].get<double>() - diameter_m,
                1.96 * few_replicates().scale_sigma * diameter_m,
                1e-7);
}

TEST(MeasureAreas, TheNumberOfThreadsChangesNoMetric) {
    types::Mesh mesh = sheet(0.4, 0.02, hills);
    mesh.sigma_m.assign(mesh.vertices.size(), 0.002F);
    MeasureOptions options = few_replicates();
    options.num_threads = 1;
    const json one = measure_areas(mesh, set_of({quadrat("q", 0.05, 0.35)}), options);
    options.num_threads = 4;
    EXPECT_EQ(one.dump(), measure_areas(mesh, set_of({quadrat("q", 0.05, 0.35)}), options).dump());
}

TEST(MeasureAreas, GroundTruthAreasNeedAGroundTruth) {
    AreaSet set = set_of({quadrat("q", 0.0, 0.1)});
    set.frame = AreaFrame::GroundTruth;
    EXPECT_THROW(areas_in_world(set, {}, std::nullopt), Error);
    EXPECT_THROW(measure_areas(sheet(0.1, 0.05, hills), set, {}), Error);
}

TEST(MetricsCsv, QuotesWhatHoldsCommasAndDisarmsFormulas) {
    const json metrics = {{{"figure", "cover"},
                           {"area", "=1+1"},
                           {"unit", ""},
                           {"label", "a,\"b\""},
                           {"value", 0.5},
                           {"low", 0.25},
                           {"high", 0.75},
                           {"method", "m"}},
                          {{"figure", "rugosity"},
                           {"area", "q"},
                           {"unit", ""},
                           {"resolution_m", 0.01},
                           {"refused", "why"}}};
    EXPECT_EQ(metrics_csv(metrics),
              "figure,area,label,unit,resolution_m,value,low,high,method,refused\n"
              "cover,'=1+1,\"a,\"\"b\"\"\",,,0.5,0.25,0.75,m,\n"
              "rugosity,q,,,0.01,,,,,why\n");
}

}  // namespace
}  // namespace divemesh::reef
