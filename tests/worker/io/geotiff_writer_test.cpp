#include "worker/io/geotiff_writer.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <geotiff/geotiff.h>
#include <geotiff/geovalues.h>
#include <geotiff/xtiffio.h>
#include <memory>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>

#include "tests/worker/io/test_files.hpp"

namespace divemesh::io {
namespace {

struct CloseTiff {
    void operator()(TIFF* tiff) const { XTIFFClose(tiff); }
    void operator()(GTIF* keys) const { GTIFFree(keys); }
};

RasterFrame local_frame() {
    RasterFrame frame;
    frame.A << 0.0013, 0.0, -2.5, 0.0, -0.0013, 7.25;
    frame.citation = "local, metres, z up";
    return frame;
}

void write_raster(const std::filesystem::path& file,
                  const cv::Mat& raster,
                  const RasterFrame& frame,
                  int num_threads = 1) {
    GeotiffWriter writer(file, raster.size(), raster.type(), frame, num_threads);
    for (int row = 0; row < raster.rows; row += 100)  // not the height of a tile
        writer.append(raster.rowRange(row, std::min(row + 100, raster.rows)));
    writer.commit();
}

cv::Mat noisy_color(int rows, int columns) {
    cv::Mat color(rows, columns, CV_8UC4);
    cv::randu(color, 0, 255);
    for (int row = 0; row < rows; ++row)
        for (int column = 0; column < columns; ++column) color.at<cv::Vec4b>(row, column)[3] = 255;
    return color;
}

class GeotiffWriterTest : public FileTest {};

TEST_F(GeotiffWriterTest, HoldsItsPlace) {
    RasterFrame frame{32617, {}, "a reef"};
    frame.A << 0.01, 0.001, 630084.0, 0.001, -0.01, 4833438.0;

    write_raster(file("heights.tif"), cv::Mat(300, 700, CV_32F, cv::Scalar::all(-1.5)), frame);

    const std::unique_ptr<TIFF, CloseTiff> tiff(XTIFFOpen(file("heights.tif").c_str(), "r"));
    ASSERT_TRUE(tiff);
    std::uint16_t count = 0;
    double* matrix = nullptr;
    ASSERT_EQ(TIFFGetField(tiff.get(), TIFFTAG_GEOTRANSMATRIX, &count, &matrix), 1);
    ASSERT_EQ(count, 16);
    const std::array<double, 8> rows = {0.01, 0.001, 0, 630084.0, 0.001, -0.01, 0, 4833438.0};
    for (std::size_t i = 0; i < rows.size(); ++i) EXPECT_DOUBLE_EQ(matrix[i], rows[i]);
    const std::unique_ptr<GTIF, CloseTiff> keys(GTIFNew(tiff.get()));
    std::uint16_t value = 0;
    GTIFKeyGetSHORT(keys.get(), ProjectedCSTypeGeoKey, &value, 0, 1);
    EXPECT_EQ(value, 32617);
    GTIFKeyGetSHORT(keys.get(), GTModelTypeGeoKey, &value, 0, 1);
    EXPECT_EQ(value, ModelTypeProjected);
    std::array<char, 32> text{};
    GTIFKeyGetASCII(keys.get(), GTCitationGeoKey, text.data(), text.size());
    EXPECT_STREQ(text.data(), "a reef");
}

TEST_F(GeotiffWriterTest, HoldsItsPixels) {
    const cv::Mat color = noisy_color(270, 600);
    cv::Mat heights(270, 600, CV_32F);
    cv::randu(heights, -5.0, 5.0);
    heights.at<float>(3, 299) = std::nanf("");
    cv::Mat transparent = color.clone();
    transparent.at<cv::Vec4b>(0, 299) = {0, 0, 0, 0};

    write_raster(file("color.tif"), transparent, local_frame());
    write_raster(file("heights.tif"), heights, local_frame());

    const cv::Mat read = cv::imread(file("color.tif"), cv::IMREAD_UNCHANGED);
    ASSERT_EQ(read.type(), CV_8UC4);
    EXPECT_EQ(cv::norm(read, transparent, cv::NORM_INF), 0.0);
    cv::Mat read_heights = cv::imread(file("heights.tif"), cv::IMREAD_UNCHANGED);
    ASSERT_EQ(read_heights.type(), CV_32F);
    EXPECT_TRUE(std::isnan(read_heights.at<float>(3, 299)));
    for (cv::Mat* image : {&read_heights, &heights}) image->at<float>(3, 299) = 0.0F;
    EXPECT_EQ(cv::norm(read_heights, heights, cv::NORM_INF), 0.0);
}

// Reads numbers of a classic TIFF, independent of libtiff.
class ClassicTiff {
public:
    explicit ClassicTiff(std::string bytes) : bytes_(std::move(bytes)) {}

    std::uint64_t number(std::size_t offset, std::size_t size) const {
        std::uint64_t value = 0;
        for (std::size_t i = 0; i < size; ++i)
            value |= std::uint64_t{static_cast<std::uint8_t>(bytes_.at(offset + i))} << (8 * i);
        return value;
    }
    std::vector<std::uint64_t> directories() const {
        std::vector<std::uint64_t> offsets;
        for (std::uint64_t next = number(4, 4); next != 0;
             next = number(next + 2 + 12 * number(next, 2), 4))
            offsets.push_back(next);
        return offsets;
    }
    // The values of a tag of SHORT or LONG.
    std::vector<std::uint64_t> values(std::uint64_t directory, std::uint64_t tag) const {
        for (std::uint64_t i = 0; i < number(directory, 2); ++i) {
            const std::uint64_t field = directory + 2 + 12 * i;
            if (number(field, 2) != tag) continue;
            const std::uint64_t size = number(field + 2, 2) == 3 ? 2 : 4;
            const std::uint64_t count = number(field + 4, 4);
            const std::uint64_t from = size * count <= 4 ? field + 8 : number(field + 8, 4);
            std::vector<std::uint64_t> values;
            for (std::uint64_t k = 0; k < count; ++k)
                values.push_back(number(from + k * size, size));
            return values;
        }
        return {};
    }

private:
    std::string bytes_;
};

// The layout that rio-cogeo and GDAL's validate_cloud_optimized_geotiff.py ask for.
TEST_F(GeotiffWriterTest, IsCloudOptimised) {
    write_raster(file("color.tif"), noisy_color(600, 1100), local_frame());
    const std::string bytes = FileTest::read(file("color.tif"));
    const ClassicTiff tiff(bytes);

    const auto directories = tiff.directories();

    ASSERT_EQ(directories.size(), 4U);  // 1100, 550, 275, 138 pixels wide
    EXPECT_EQ(bytes.substr(8, 43), "GDAL_STRUCTURAL_METADATA_SIZE=000140 bytes\n");
    EXPECT_NE(bytes.find("LAYOUT=IFDS_BEFORE_DATA\n"), std::string::npos);
    EXPECT_TRUE(std::is_sorted(directories.begin(), directories.end()));
    std::uint64_t end = 0;  // of the tiles before
    for (std::size_t i = directories.size(); i-- > 0;) {
        EXPECT_EQ(tiff.values(directories[i], TIFFTAG_IMAGEWIDTH),
                  (std::vector<std::uint64_t>{(1100U + (1U << i) - 1) >> i}));
        EXPECT_EQ(tiff.values(directories[i], TIFFTAG_TILEWIDTH),
                  (std::vector<std::uint64_t>{256}));
        EXPECT_EQ(tiff.values(directories[i], TIFFTAG_SUBFILETYPE).size(), i == 0 ? 0U : 1U);
        const auto offsets = tiff.values(directories[i], TIFFTAG_TILEOFFSETS);
        const auto sizes = tiff.values(directories[i], TIFFTAG_TILEBYTECOUNTS);
        ASSERT_EQ(offsets.size(), sizes.size());
        EXPECT_GT(offsets.front(), directories.back());
        for (std::size_t tile = 0; tile < offsets.size(); ++tile) {
            EXPECT_EQ(tiff.number(offsets[tile] - 4, 4), sizes[tile]);  // the leader
            EXPECT_GE(offsets[tile] - 4, end);
            end = offsets[tile] + sizes[tile] + 4;
            EXPECT_EQ(bytes.substr(end - 4, 4), bytes.substr(end - 8, 4));  // the trailer
        }
    }
    EXPECT_EQ(end, bytes.size());
}

TEST_F(GeotiffWriterTest, ThreadsDoNotChangeTheFile) {
    const cv::Mat color = noisy_color(700, 900);
    write_raster(file("one.tif"), color, local_frame(), 1);
    write_raster(file("four.tif"), color, local_frame(), 4);

    EXPECT_EQ(FileTest::read(file("one.tif")), FileTest::read(file("four.tif")));
}

TEST_F(GeotiffWriterTest, OtherPixelsAreRefused) {
    EXPECT_EQ(error_of([&] {
                  GeotiffWriter(file("grey.tif"), {3, 3}, CV_8UC1, local_frame(), 1);
              }).code(),
              ErrorCode::InvalidArgument);
}

TEST_F(GeotiffWriterTest, WithoutCommitThereIsNoFile) {
    { GeotiffWriter writer(file("color.tif"), {3, 3}, CV_8UC4, local_frame(), 1); }

    EXPECT_TRUE(std::filesystem::is_empty(file("")));
}

// Returns what a program prints; empty if it fails or is not there.
std::string printed_by(const std::string& command) {
    const std::unique_ptr<FILE, int (*)(FILE*)> pipe(popen(command.c_str(), "r"),
                                                     [](FILE* stream) { return pclose(stream); });
    std::string output;
    std::array<char, 4096> bytes{};
    while (const std::size_t size = std::fread(bytes.data(), 1, bytes.size(), pipe.get()))
        output.append(bytes.data(), size);
    return output;
}

// What GDAL itself, with which QGIS and rasterio read, makes of our files.
class GdalItselfTest : public GeotiffWriterTest {
protected:
    void SetUp() override {
        if (printed_by("command -v gdalinfo").empty()) GTEST_SKIP() << "install gdal-bin";
    }
    nlohmann::json info(const char* name, const char* options = "") const {
        const std::string path = "'" + file(name).string() + "'";
        EXPECT_EQ(printed_by("gdalinfo " + path + " 2>&1 >/dev/null"), "");  // no warning
        const std::string text =
            printed_by("gdalinfo -json " + std::string(options) + " " + path + " 2>/dev/null");
        return nlohmann::json::parse(text, nullptr, false);
    }
};

TEST_F(GdalItselfTest, ReadsALocalSystemInMetres) {
    cv::Mat heights(600, 1100, CV_32F, cv::Scalar::all(-4.5));
    heights.rowRange(0, 300) = -3.5;
    heights.colRange(0, 100) = std::nanf("");
    write_raster(file("heights.tif"), heights, local_frame());

    const nlohmann::json info = this->info("heights.tif", "-stats");

    EXPECT_EQ(info["size"], nlohmann::json({1100, 600}));
    EXPECT_EQ(info["geoTransform"], nlohmann::json({-2.5, 0.0013, 0.0, 7.25, 0.0, -0.0013}));
    const std::string system = info["coordinateSystem"]["wkt"];
    EXPECT_TRUE(system.starts_with("ENGCRS[\"local, metres, z up\"")) << system;
    EXPECT_NE(system.find("LENGTHUNIT[\"metre\",1,"), std::string::npos) << system;
    EXPECT_EQ(info["metadata"]["IMAGE_STRUCTURE"]["LAYOUT"], "COG");
    EXPECT_EQ(info["metadata"]["IMAGE_STRUCTURE"]["COMPRESSION"], "DEFLATE");
    const nlohmann::json& band = info["bands"][0];
    EXPECT_EQ(band["type"], "Float32");
    EXPECT_EQ(band["block"], nlohmann::json({256, 256}));
    EXPECT_EQ(band["noDataValue"], "NaN");
    ASSERT_EQ(band["overviews"].size(), 3U);
    EXPECT_EQ(band["overviews"][1]["size"], nlohmann::json({275, 150}));
    EXPECT_DOUBLE_EQ(band["minimum"].get<double>(), -4.5);
    EXPECT_DOUBLE_EQ(band["mean"].get<double>(), -4.0);
}

TEST_F(GdalItselfTest, ReadsColoursInUtm) {
    RasterFrame frame{32633, {}, "WGS 84 / UTM; a reef"};
    frame.A << 0.001, 0.0, 500'000.0, 0.0, -0.001, 4'900'000.0;
    write_raster(file("color.tif"), noisy_color(300, 300), frame);

    const nlohmann::json info = this->info("color.tif");

    EXPECT_EQ(info["stac"]["proj:epsg"], 32633);
    ASSERT_EQ(info["bands"].size(), 4U);
    EXPECT_EQ(info["bands"][0]["colorInterpretation"], "Red");
    EXPECT_EQ(info["bands"][3]["colorInterpretation"], "Alpha");
    EXPECT_EQ(info["geoTransform"][0], 500'000.0);
}

}  // namespace
}  // namespace divemesh::io
