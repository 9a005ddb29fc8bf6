#include "worker/io/raster_reader.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <opencv2/core.hpp>

#include "tests/worker/io/test_files.hpp"
#include "worker/io/geotiff_writer.hpp"

namespace divemesh::io {
namespace {

class RasterReaderTest : public FileTest {
protected:
    // Writes 700 x 600 heights: the column plus a thousandth of the row.
    std::filesystem::path written() const {
        RasterFrame frame;
        frame.A << 0.5, 0.0, 0.0, 0.0, -0.5, 0.0;
        GeotiffWriter writer(file("heights.tif"), {700, 600}, CV_32F, frame, 1);
        writer.append(heights());
        writer.commit();
        return file("heights.tif");
    }
    static cv::Mat heights() {
        cv::Mat heights(600, 700, CV_32F);
        for (int row = 0; row < heights.rows; ++row)
            for (int column = 0; column < heights.cols; ++column)
                heights.at<float>(row, column) =
                    static_cast<float>(column) + 0.001F * static_cast<float>(row);
        return heights;
    }
};

TEST_F(RasterReaderTest, ReadsAnyRows) {
    RasterReader reader(written());

    EXPECT_EQ(reader.size(), cv::Size(700, 600));
    EXPECT_EQ(reader.type(), CV_32F);
    const cv::Mat rows = reader.rows(200, 350);
    EXPECT_EQ(cv::norm(rows, heights().rowRange(200, 550), cv::NORM_INF), 0.0);
}

TEST_F(RasterReaderTest, ReadsTheLargestOverviewThatFits) {
    EXPECT_EQ(RasterReader(written(), 700).size(), cv::Size(700, 600));
    EXPECT_EQ(RasterReader(written(), 699).size(), cv::Size(350, 300));
    RasterReader smallest(written(), 300);

    ASSERT_EQ(smallest.size(), cv::Size(175, 150));
    EXPECT_NEAR(smallest.rows(10, 1).at<float>(0, 20), 81.5 + 0.0415, 1e-4);  // mean of 4 x 4
}

TEST_F(RasterReaderTest, NamesTheFileThatIsNotThereOrNone) {
    EXPECT_EQ(error_of([&] { RasterReader(file("none.tif")); }).code(), ErrorCode::NotFound);
    const std::string whole = FileTest::read(written());
    write("noise.tif", "no raster");
    write("short.tif", whole.substr(0, 3000));
    for (const char* name : {"noise.tif", "short.tif"}) {
        const Error error = error_of([&] {
            RasterReader reader(file(name));
            reader.rows(0, reader.size().height);
        });
        EXPECT_EQ(error.code(), ErrorCode::BadData);
        EXPECT_NE(std::string(error.what()).find(name), std::string::npos);
    }
}

TEST_F(RasterReaderTest, ChangedBytesAreAnErrorAndNotACrash) {
    const std::string whole = FileTest::read(written());
    for (std::size_t i = 0; i < std::min<std::size_t>(whole.size(), 1500); i += 31) {
        std::string broken = whole;
        broken[i] = static_cast<char>(broken[i] ^ 0x55);
        write("broken.tif", broken);
        try {
            RasterReader reader(file("broken.tif"));
            if (reader.size().area() < 10'000'000) reader.rows(0, reader.size().height);
        } catch (const Error&) {
        }
    }
}

}  // namespace
}  // namespace divemesh::io
