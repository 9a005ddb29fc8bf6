#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>

#include "tests/end_to_end/service.hpp"
#include "tests/paths.hpp"

namespace divemesh {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using nlohmann::json;

class DrawingTest : public testing::Test {
protected:
    json read(const fs::path& file) const { return json::parse(std::ifstream(file)); }

    Service service;
};

// In a browser's document, by events as a person makes them; what is drawn is then measured.
TEST_F(DrawingTest, WhatIsDrawnOnThePageLiesWhereItWasDrawnAndIsMeasured) {
    const fs::path scripts = source_directory() / "tests/end_to_end/js";
    if (!fs::exists(scripts / "node_modules/jsdom"))
        GTEST_SKIP() << "run npm ci in tests/end_to_end/js first";
    const std::string model = (service / "model").string();
    const std::string page = (service / "draw.html").string();
    ASSERT_EQ(service.run({"reconstruct", small_dive().string(), "--out", model}, 300s).exit_code,
              0);
    const Outcome written = service.run({"measure", model, "--draw", page}, 60s);
    ASSERT_EQ(written.exit_code, 0) << written.err;

    const json corners = {{380, 280}, {420, 280}, {420, 320}, {380, 320}};
    Process node({"/usr/bin/env",
                  "node",
                  (scripts / "draw_areas.mjs").string(),
                  page,
                  json{{"quadrat", "", corners},
                       {"polygon", "Porites", {{390, 290}, {410, 290}, {400, 310}}}}
                      .dump()},
                 service / ".");
    ASSERT_EQ(node.wait(60s), 0) << node.stderr_text();
    std::ofstream(service / "areas.json") << node.stdout_text();

    const json areas = json::parse(node.stdout_text()).at("areas");
    ASSERT_EQ(areas.size(), 2U);
    EXPECT_EQ(areas[1].at("label"), "Porites");
    // The image fits into 800 x 600 and lies in the middle.
    const json mosaic = read(fs::path(model) / "mosaic.json");
    const double width_px = mosaic.at("width_px"), height_px = mosaic.at("height_px");
    const double m_per_screen_px =
        mosaic.at("pixel_m").get<double>() * std::max(width_px / 800.0, height_px / 600.0);
    const double middle_x_m =
        mosaic.at("corner_x_m").get<double>() + 0.5 * width_px * mosaic.at("pixel_m").get<double>();
    const double middle_y_m = mosaic.at("corner_y_m").get<double>() -
                              0.5 * height_px * mosaic.at("pixel_m").get<double>();
    for (std::size_t i = 0; i < 4; ++i) {
        const json& corner = areas[0].at("corners")[i];
        EXPECT_NEAR(corner[0].get<double>(),
                    middle_x_m + m_per_screen_px * (corners[i][0].get<double>() - 400.0),
                    1e-3);
        EXPECT_NEAR(corner[1].get<double>(),
                    middle_y_m - m_per_screen_px * (corners[i][1].get<double>() - 300.0),
                    1e-3);
    }

    const Outcome measured = service.run(
        {"measure", model, "--areas", (service / "areas.json").string(), "--json"}, 120s);
    ASSERT_EQ(measured.exit_code, 0) << measured.err;
    EXPECT_NE(measured.out.find("Porites"), std::string::npos);
    EXPECT_EQ(json::parse(measured.out).at("reconstruction").at("verdict"),
              read(fs::path(model) / "metrics.json").at("verdict"));
}

}  // namespace
}  // namespace divemesh
