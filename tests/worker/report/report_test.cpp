#include "worker/report/report.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "worker/report/svg_plot.hpp"

namespace divemesh::report {
namespace {

using nlohmann::json;

types::Trajectory path() {
    types::Trajectory trajectory;
    for (int i = 0; i < 50; ++i)
        trajectory.push_back({i * std::int64_t{100'000'000},
                              Eigen::Isometry3d(Eigen::Translation3d(0.1 * i, 0.0, 1.0))});
    return trajectory;
}

json metrics() {
    return {{"version", "0.1.0"},
            {"preset", "paper"},
            {"dive", {{"name", "Lotus <script>alert(1)</script>"}, {"duration_s", 5.0}}},
            {"trajectory", {{"final", {{"ate_rmse_m", 0.0123}}}}},
            {"findings",
             {{{"severity", "warning"},
               {"code", "x"},
               {"where", "cam0/data.csv:3"},
               {"message", "<img src=x onerror=y>"},
               {"remedy", "\"quoted\""}}}}};
}

TEST(Report, WhatComesFromTheDiveIsEscaped) {
    const json document = metrics();
    const std::string html = report_html({document, path(), {}, ""});
    EXPECT_EQ(html.find("<script"), std::string::npos);
    EXPECT_EQ(html.find("<img src=x"), std::string::npos);
    EXPECT_NE(html.find("Lotus &lt;script&gt;"), std::string::npos);
    EXPECT_NE(html.find("&quot;quoted&quot;"), std::string::npos);
}

TEST(Report, LoadsNothingFromAnywhere) {
    const json document = metrics();
    const std::string html = report_html({document, path(), {}, "\x89PNG"});
    EXPECT_EQ(html.find("http"), std::string::npos);
    EXPECT_NE(html.find("src=\"data:image/png;base64,iVBORw==\""), std::string::npos);
}

TEST(Report, MetricsAreShownInUnitsForPeopleAndMissingOnesNotAtAll) {
    const json document = metrics();
    const std::string html = report_html({document, path(), {}, ""});
    EXPECT_NE(html.find("12.3 mm"), std::string::npos);
    EXPECT_EQ(html.find("Mesh accuracy"), std::string::npos);
}

TEST(Report, WhatIsMissingOfTheSurfaceIsShown) {
    json document = metrics();
    document["mesh"] = {{"covered_share", 0.88},
                        {"covered_share_of_matched", 0.91},
                        {"num_holes", 7},
                        {"largest_hole_m2", 0.25},
                        {"small_components_m2", 0.5},
                        {"cut_by_sigma_m2", 1.5}};
    const std::string html = report_html({document, path(), {}, ""});
    for (const char* value : {"88 %", "91 %", ">7<", "0.250 m²", "0.500 m²", "1.500 m²"})
        EXPECT_NE(html.find(value), std::string::npos) << value;
}

TEST(Report, TheVerdictStandsAboveAllElse) {
    json document = metrics();
    EXPECT_EQ(report_html({document, path(), {}, ""}).find("Usable"), std::string::npos);
    document["verdict"] = "usable_with_restrictions";
    document["restrictions"] = {"path", "scale"};
    const std::string html = report_html({document, path(), {}, ""});
    const std::size_t verdict = html.find("Usable with restrictions: path, scale");
    ASSERT_NE(verdict, std::string::npos);
    EXPECT_LT(verdict, html.find("<svg"));
    document["verdict"] = "not_usable";
    document["restrictions"] = {"all"};
    EXPECT_NE(report_html({document, path(), {}, ""}).find(">Not usable<"), std::string::npos);
}

TEST(Report, HasTwoPlotsEvenForAnEmptyTrajectory) {
    const json document = metrics();
    const std::string html = report_html({document, {}, {}, ""});
    const std::size_t first = html.find("<svg");
    ASSERT_NE(first, std::string::npos);
    EXPECT_NE(html.find("<svg", first + 1), std::string::npos);
    const std::string plots = html.substr(first, html.rfind("</svg>") - first);
    EXPECT_EQ(plots.find("nan"), std::string::npos);
    EXPECT_EQ(plots.find("inf"), std::string::npos);
}

TEST(SvgPlot, LongLinesAreThinned) {
    PlotLine line{"a", "red", {}, {}};
    for (int i = 0; i < 100'000; ++i) {
        line.x.push_back(i);
        line.y.push_back(std::sin(i * 0.001));
    }
    EXPECT_LT(svg_plot({"t", "x", "y", {line}, false}).size(), 40'000U);
}

TEST(SvgPlot, NamesThatHaveNoRoomInARowStandBelowOneAnother) {
    Plot plot{"t", "x", "y", {}, false};
    for (int i = 0; i < 7; ++i)
        plot.lines.push_back(
            {"a name of some length " + std::to_string(i), "#000", {0, 1}, {0, 1}});
    const std::string svg = svg_plot(plot);
    for (const PlotLine& line : plot.lines) {
        const std::size_t end = svg.find(">" + line.name);
        ASSERT_NE(end, std::string::npos);
        const std::size_t x = svg.find("x=\"", svg.rfind("<text", end));
        EXPECT_LT(std::stod(svg.substr(x + 3)) + 6.0 * static_cast<double>(line.name.size()),
                  560.0);
    }
}

}  // namespace
}  // namespace divemesh::report
