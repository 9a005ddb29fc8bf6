#include "worker/report/drawing_page.hpp"

#include <gtest/gtest.h>

#include <cstring>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>

#include "schemas/base64.hpp"
#include "schemas/error.hpp"
#include "tests/temporary_folder.hpp"
#include "worker/io/mosaic_files.hpp"

namespace divemesh::report {
namespace {

class DrawingPageTest : public testing::Test {
protected:
    DrawingPageTest() {
        std::ofstream(folder_ / "metrics.json")
            << nlohmann::json{{"dive", {{"name", "</script><b>reef"}}}};
    }
    // Writes 40 x 20 pixels of 0.1 m from (1, 3): a floor at -2 m, its north-west quarter at -1.5
    // m, no data in the south-east.
    void write_mosaic() const {
        cv::Mat color(20, 40, CV_8UC4, cv::Scalar(200, 0, 0, 255));
        color(cv::Rect(20, 10, 20, 10)) = cv::Scalar::all(0);
        cv::Mat height_m(20, 40, CV_32F, cv::Scalar::all(-2.0));
        height_m(cv::Rect(0, 0, 20, 10)) = -1.5;
        height_m(cv::Rect(20, 10, 20, 10)) = std::numeric_limits<float>::quiet_NaN();
        io::MosaicWriter writer(folder_.path(), {40, 20, 0.1, 1.0, 3.0}, std::nullopt, 1);
        writer.append(color, height_m, height_m);
        writer.commit();
    }
    nlohmann::json data() const {
        const std::string page = drawing_page(io::ReconstructionFolder(folder_.path()));
        const std::string begin = R"(<script id="data" type="application/json">)";
        const auto from = page.find(begin) + begin.size();
        return nlohmann::json::parse(page.substr(from, page.find("</script>", from) - from));
    }

    TemporaryFolder folder_;
};

TEST_F(DrawingPageTest, HoldsWhereTheImageIsAndHowHighTheSurface) {
    write_mosaic();
    const nlohmann::json data = this->data();
    EXPECT_EQ(data["title"], "</script><b>reef");
    EXPECT_EQ(data["corner_x_m"], 1.0);
    EXPECT_EQ(data["corner_y_m"], 3.0);
    EXPECT_EQ(data["pixel_m"], 0.1);
    const nlohmann::json& grid = data["heights"];
    ASSERT_EQ(grid["width"], 40);
    ASSERT_EQ(grid["height"], 20);
    EXPECT_DOUBLE_EQ(grid["pixel_m"].get<double>(), 0.1);
    const std::string bytes = decode_base64(grid["base64"].get<std::string>()).value();
    const auto steps_at = [&](int column, int row) {
        std::uint16_t steps = 0;
        std::memcpy(&steps, bytes.data() + 2 * (40 * row + column), sizeof steps);
        return steps;
    };
    const auto height_m = [&](int column, int row) {
        return grid["lowest_m"].get<double>() +
               (steps_at(column, row) - 1) * grid["step_m"].get<double>();
    };
    EXPECT_NEAR(height_m(5, 5), -1.5, 1e-3);
    EXPECT_NEAR(height_m(30, 5), -2.0, 1e-3);
    EXPECT_EQ(steps_at(30, 15), 0);
}

TEST_F(DrawingPageTest, SaysWhatIsMissingWithoutAMosaic) {
    try {
        drawing_page(io::ReconstructionFolder(folder_.path()));
        FAIL() << "made a page of nothing";
    } catch (const Error& error) {
        EXPECT_EQ(error.code(), ErrorCode::NotFound);
        EXPECT_NE(std::string(error.what()).find("mosaic.json"), std::string::npos) << error.what();
    }
}

TEST_F(DrawingPageTest, RefusesHeightsThatAreNone) {
    write_mosaic();
    std::ofstream(folder_ / "heights.tif") << "no raster";
    EXPECT_THROW(drawing_page(io::ReconstructionFolder(folder_.path())), Error);
}

}  // namespace
}  // namespace divemesh::report
