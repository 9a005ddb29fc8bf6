#include "worker/io/mosaic_files.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgcodecs.hpp>
#include <sstream>

#include "tests/worker/io/test_files.hpp"
#include "worker/io/raster_reader.hpp"

namespace divemesh::io {
namespace {

// Returns 5001 x 2001 pixels of 1 mm from (1, 3).
types::RasterGrid millimetres() { return {5001, 2001, 0.001, 1.0, 3.0}; }

class MosaicFilesTest : public FileTest {
protected:
    // Writes a floor at -2 m with a sigma of 3 mm whose eastern fifth is missing; returns the
    // preview.
    cv::Mat written(const types::RasterGrid& grid, int num_threads = 1) const {
        MosaicWriter writer(file(""), grid, std::nullopt, num_threads);
        const int width = grid.width_px * 4 / 5;
        for (int row = 0; row < grid.height_px; row += 300) {
            const cv::Size size(grid.width_px, std::min(300, grid.height_px - row));
            cv::Mat color(size, CV_8UC4, cv::Scalar::all(0));
            cv::Mat height_m(size, CV_32F, cv::Scalar::all(std::nan("")));
            cv::Mat sigma_m = height_m.clone();
            color.colRange(0, width) = cv::Scalar(50, 100, 200, 255);
            height_m.colRange(0, width) = -2.0;
            sigma_m.colRange(0, width) = 0.003;
            writer.append(color, height_m, sigma_m);
        }
        writer.commit();
        return writer.preview();
    }
    nlohmann::json description() const {
        return nlohmann::json::parse(FileTest::read(file("mosaic.json")));
    }
};

TEST_F(MosaicFilesTest, HoldColoursHeightsAndTheirSigma) {
    written({501, 201, 0.01, 1.0, 3.0});

    RasterReader color(file("mosaic.tif"));
    RasterReader heights(file("heights.tif"));
    RasterReader sigma(file("heights_sigma.tif"));
    EXPECT_EQ(color.rows(100, 1).at<cv::Vec4b>(0, 100), cv::Vec4b(50, 100, 200, 255));
    EXPECT_EQ(heights.rows(100, 1).at<float>(0, 100), -2.0F);
    EXPECT_FLOAT_EQ(sigma.rows(100, 1).at<float>(0, 100), 0.003F);
    EXPECT_EQ(color.rows(100, 1).at<cv::Vec4b>(0, 450), cv::Vec4b());
    EXPECT_TRUE(std::isnan(heights.rows(100, 1).at<float>(0, 450)));
}

TEST_F(MosaicFilesTest, TheDescriptionPlacesPreviewAndGeoTiffs) {
    const cv::Mat preview = written(millimetres());

    const nlohmann::json json = description();
    EXPECT_EQ(json["geotiff"]["width_px"], 5001);
    EXPECT_EQ(json["geotiff"]["pixel_m"], 0.001);
    EXPECT_EQ(json["geotiff"]["corner_x_m"], 1.0);
    EXPECT_EQ(json["geotiff"]["corner_y_m"], 3.0);
    EXPECT_EQ(json["width_px"], 2501);  // half, to stay below 4096
    EXPECT_EQ(json["pixel_m"], 0.002);
    EXPECT_EQ(json["corner_x_m"], 1.0);
    const types::RasterGrid grid = mosaic_grid_of(json, "mosaic.json");
    EXPECT_EQ(grid.width_px, 5001);
    EXPECT_EQ(grid.corner_y_m, 3.0);
    const cv::Mat image = cv::imread(file("mosaic.png"), cv::IMREAD_UNCHANGED);
    ASSERT_EQ(image.type(), CV_8UC4);
    ASSERT_EQ(image.cols, 2501);
    EXPECT_EQ(cv::norm(image, preview, cv::NORM_INF), 0.0);
}

TEST_F(MosaicFilesTest, WorldFilesGiveTheCentreOfTheFirstPixel) {
    written(millimetres());

    const auto values = [&](const char* name) {
        std::istringstream text(FileTest::read(file(name)));
        std::vector<double> read;
        for (double value = 0.0; text >> value;) read.push_back(value);
        return read;
    };
    for (const char* name : {"mosaic.tfw", "heights.tfw"})
        EXPECT_EQ(values(name), (std::vector<double>{0.001, 0, 0, -0.001, 1.0005, 2.9995})) << name;
    EXPECT_EQ(values("mosaic.pgw"), (std::vector<double>{0.002, 0, 0, -0.002, 1.001, 2.999}));
}

TEST_F(MosaicFilesTest, OnePixelIsEnough) {
    EXPECT_EQ(written({}).size(), cv::Size(1, 1));
    EXPECT_EQ(RasterReader(file("mosaic.tif")).rows(0, 1).at<cv::Vec4b>(0, 0), cv::Vec4b());
}

TEST_F(MosaicFilesTest, ALargeImageOfHardlyAnythingIsASmallFile) {
    written({32'767, 300, 0.001, 0.0, 0.0});

    EXPECT_LT(std::filesystem::file_size(file("heights.tif")), 2'000'000U);
}

TEST_F(MosaicFilesTest, ThreadsDoNotChangeThem) {
    const std::vector<const char*> names = {
        "mosaic.tif", "heights.tif", "heights_sigma.tif", "mosaic.png"};
    written({1251, 501, 0.004, 1.0, 3.0}, 1);
    std::vector<std::string> of_one;
    for (const char* name : names) of_one.push_back(FileTest::read(file(name)));
    written({1251, 501, 0.004, 1.0, 3.0}, 4);

    for (std::size_t i = 0; i < names.size(); ++i)
        EXPECT_EQ(FileTest::read(file(names[i])), of_one[i]) << names[i];
}

TEST_F(MosaicFilesTest, ADescriptionOfAnOlderVersionIsRefused) {
    const Error error = error_of([] { mosaic_grid_of({{"pixel_m", 0.01}}, "model/mosaic.json"); });

    EXPECT_EQ(error.code(), ErrorCode::BadData);
    EXPECT_NE(std::string(error.what()).find("model/mosaic.json"), std::string::npos);
}

}  // namespace
}  // namespace divemesh::io
