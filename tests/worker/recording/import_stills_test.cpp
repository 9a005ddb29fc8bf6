#include "worker/recording/import_stills.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <functional>
#include <map>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "schemas/error.hpp"
#include "tests/paths.hpp"
#include "tests/worker/recording/exif_writer.hpp"
#include "tests/worker/recording/import_fixture.hpp"
#include "worker/base/atomic_file.hpp"
#include "worker/dive/csv.hpp"
#include "worker/dive/dive.hpp"
#include "worker/recording/input_file.hpp"

namespace divemesh::recording {
namespace {

namespace fs = std::filesystem;

constexpr int kNumPairs = 5;
constexpr std::int64_t kStart_ns = 1'700'000'000'000'000'000;
constexpr std::int64_t kPeriod_ns = 100'000'000;

std::string text_of(const fs::path& file) { return InputFile(file).read(0, 1LL << 30U); }

void put(const fs::path& file, const std::string& bytes) {
    fs::create_directories(file.parent_path());
    base::write_file(file, bytes, base::Durability::Unsynced);
}

std::string encoded(const char* extension, const cv::Mat& pixels) {
    std::vector<unsigned char> bytes;
    cv::imencode(extension, pixels, bytes);
    return {bytes.begin(), bytes.end()};
}

cv::Mat decoded(const std::string& bytes) {
    const std::vector<char> buffer(bytes.begin(), bytes.end());
    return cv::imdecode(buffer, cv::IMREAD_UNCHANGED);
}

// An image of 64 x 48 px that no other camera and moment has.
cv::Mat made_image(int camera, int moment, int type = CV_8UC1) {
    cv::Mat pixels(48, 64, type);
    cv::RNG random(static_cast<std::uint64_t>(1 + camera + 2 * moment));
    random.fill(pixels, cv::RNG::UNIFORM, 0, CV_MAT_DEPTH(type) == CV_16U ? 65536 : 256);
    return pixels;
}

std::string sensor_yaml(double x_m) {
    return "T_BS:\n  data: [1, 0, 0, " + std::to_string(x_m) +
           ", 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]\nresolution: [64, 48]\ncamera_model: pinhole\n"
           "intrinsics: [60, 60, 32, 24]\ndistortion_model: radial-tangential\n"
           "distortion_coefficients: [0, 0, 0, 0]\n";
}

std::string padded(int number, int width = 6) {
    const std::string digits = std::to_string(number);
    return std::string(static_cast<std::size_t>(width) - digits.size(), '0') + digits;
}

// The images of a dive's camera by their times.
using Images = std::map<std::int64_t, std::string>;

class ImportStillsTest : public ImportFixture<StillsImport, StillsOptions> {
protected:
    ImportStillsTest() {
        put(calibration() / "cam0" / "sensor.yaml", sensor_yaml(0.0));
        put(calibration() / "cam1" / "sensor.yaml", sensor_yaml(0.1));
    }
    fs::path calibration() const { return folder_ / "calibration"; }
    fs::path recorded() const { return folder_ / "recorded"; }
    StillsOptions options_for(std::vector<fs::path> folders) const {
        StillsOptions options;
        options.folders = std::move(folders);
        options.out = folder_ / "dive";
        options.calibration = {calibration()};
        return options;
    }
    Images images_of(const char* camera) const {
        Images images;
        const fs::path folder = folder_ / "dive" / "mav0" / camera;
        dive::for_each_csv_row(text_of(folder / "data.csv"),
                               [&](std::int64_t, std::span<const std::string_view> fields) {
                                   images[*dive::parse_integer(fields[0])] =
                                       text_of(folder / "data" / std::string(fields[1]));
                               });
        return images;
    }
    std::string message_of(const std::string& code) const {
        for (const Finding& finding : findings_)
            if (finding.code == code) return finding.message;
        return "";
    }
    void expect_images(const char* camera, const std::function<std::string(int)>& bytes) const {
        const Images images = images_of(camera);
        ASSERT_EQ(images.size(), static_cast<std::size_t>(kNumPairs)) << camera;
        for (int i = 0; i < kNumPairs; ++i) {
            const auto image = images.find(kStart_ns + i * kPeriod_ns);
            ASSERT_NE(image, images.end()) << camera << " " << i;
            EXPECT_TRUE(image->second == bytes(i)) << camera << " " << i;
        }
    }
    static std::string png(int camera, int moment) {
        return encoded(".png", made_image(camera, moment));
    }
    void expect_pairs() const {
        expect_images("cam0", [](int i) { return png(0, i); });
        expect_images("cam1", [](int i) { return png(1, i); });
    }
};

TEST_F(ImportStillsTest, TwoFoldersOfASharedDiveKeepTheirBytesAndTimes) {
    const fs::path mav0 = shared_data("tank") / "mav0";
    if (!fs::exists(mav0)) GTEST_SKIP() << mav0 << " is missing";
    for (const char* camera : {"cam0", "cam1"})
        for (int i = 0; i < kNumPairs; ++i) {
            const std::string name = std::to_string(1'600'000'000'000'000'000 + i * kPeriod_ns);
            put(folder_ / camera / ("x_" + name + ".JPG"),
                text_of(mav0 / camera / "data" / (name + ".jpg")));
        }
    put(folder_ / "cam0" / "._x_1600000000000000000.JPG", "Mac OS X");
    put(folder_ / "cam1" / "__MACOSX" / "x_1600000000000000000.JPG", "Mac OS X");
    put(folder_ / "cam1" / "Thumbs.db", "thumbs");
    fs::create_symlink("/etc/hostname", folder_ / "cam0" / "y_1600000000050000000.jpg");
    StillsOptions options = options_for({folder_ / "cam0", folder_ / "cam1"});
    options.calibration = {shared_data("tank")};
    const ImportCounts counts = imported(options);
    EXPECT_EQ(counts.num_left, kNumPairs);
    for (const char* camera : {"cam0", "cam1"})
        for (const auto& [time_ns, bytes] : images_of(camera))
            EXPECT_EQ(bytes, text_of(mav0 / camera / "data" / (std::to_string(time_ns) + ".jpg")));
    const auto dive = dive::Dive::open(folder_ / "dive", folder_.path());
    EXPECT_EQ(dive->num_frames(), kNumPairs);
    EXPECT_NE(message_of("file_left_out").find("link"), std::string::npos);
}

TEST_F(ImportStillsTest, NamesStateTimesInEveryUnit) {
    const std::map<std::string, std::function<std::string(std::int64_t)>> units = {
        {"nanoseconds", [](std::int64_t ns) { return std::to_string(ns); }},
        {"microseconds", [](std::int64_t ns) { return std::to_string(ns / 1000); }},
        {"milliseconds", [](std::int64_t ns) { return std::to_string(ns / 1000000); }},
        {"seconds", [](std::int64_t ns) {
             return std::to_string(ns / 1000000000) + "." +
                    padded(static_cast<int>(ns % 1000000000), 9);
         }}};
    for (const auto& [unit, name_of] : units) {
        fs::remove_all(recorded());
        fs::remove_all(folder_ / "dive");
        for (int i = 0; i < kNumPairs; ++i) {
            const std::string name = name_of(kStart_ns + i * kPeriod_ns);
            put(recorded() / ("L_" + name + ".png"), png(0, i));
            put(recorded() / ("R_" + name + ".png"), png(1, i));
        }
        imported(options_for({recorded()}));
        expect_pairs();
        EXPECT_NE(message_of("pairs_made").find("5 pairs of 5 left and 5 right"),
                  std::string::npos);
        EXPECT_NE(message_of("pairs_made").find(unit), std::string::npos);
    }
}

TEST_F(ImportStillsTest, CountersPairImagesAtTheStatedRateAndMissingOnesLeaveGaps) {
    for (int i = 0; i < kNumPairs; ++i) {
        if (i != 2) put(recorded() / "left" / ("f" + padded(i) + ".png"), png(0, i));
        if (i != 3) put(recorded() / "right" / ("g" + padded(i) + ".png"), png(1, i));
    }
    StillsOptions options = options_for({recorded()});
    EXPECT_NE(refusal_of(options).find("--rate"), std::string::npos);
    options.times.rate_hz = 4.0;
    imported(options);
    const Images left = images_of("cam0");
    const Images right = images_of("cam1");
    EXPECT_EQ(left.size(), 4U);
    EXPECT_EQ(left.at(1'000'000'000), png(0, 4));
    EXPECT_EQ(right.at(1'000'000'000), png(1, 4));
    EXPECT_EQ(right.at(500'000'000), png(1, 2));
    EXPECT_FALSE(left.contains(500'000'000));
    EXPECT_NE(message_of("pairs_made").find("3 pairs"), std::string::npos);
}

TEST_F(ImportStillsTest, AFolderOfABagIsNoFolderOfImages) {
    put(recorded() / "left" / "0.png", png(0, 0));
    EXPECT_TRUE(is_image_folder(recorded()));
    EXPECT_FALSE(is_image_folder(recorded() / "left" / "0.png"));
    EXPECT_FALSE(is_image_folder(recorded() / "missing"));
    put(recorded() / "bag_0.db3", "SQLite format 3");
    EXPECT_FALSE(is_image_folder(recorded()));
}

TEST_F(ImportStillsTest, ARateThatIsNoneIsRefused) {
    put(recorded() / "left" / "0.png", png(0, 0));
    put(recorded() / "right" / "0.png", png(1, 0));
    StillsOptions options = options_for({recorded()});
    for (const double rate_hz : {0.0, -1.0, std::nan(""), 1e9}) {
        options.times.rate_hz = rate_hz;
        EXPECT_NE(refusal_of(options).find("--rate"), std::string::npos) << rate_hz;
    }
}

std::string photo(int camera, int moment, const std::string& date, const std::string& fraction) {
    ExifWriter::Texts texts = {{0x9003, date}};
    if (!fraction.empty()) texts.emplace_back(0x9291, fraction);
    return ExifWriter::in_jpeg(encoded(".jpg", made_image(camera, moment, CV_8UC3)),
                               ExifWriter(ByteOrder::Big).tiff({}, texts));
}

// Stills taken by hand, an hour and 2.5 s apart by the clocks; the left camera missed the first.
TEST_F(ImportStillsTest, ClocksOfTwoCamerasMayDifferByAConstant) {
    const int seconds[] = {3, 10, 14, 33, 51};
    for (int i = 0; i < kNumPairs; ++i) {
        const std::string left = "2024:05:06 07:08:" + padded(seconds[i], 2);
        const std::string right = "2024:05:06 08:08:" + padded(seconds[i] + 2, 2);
        if (i > 0)
            put(folder_ / "a" / ("GOPR" + padded(7 + i, 4) + ".JPG"), photo(0, i, left, "25"));
        put(folder_ / "b" / ("GOPR" + padded(93 + i, 4) + ".JPG"), photo(1, i, right, "75"));
    }
    imported(options_for({folder_ / "a", folder_ / "b"}));
    const Images left = images_of("cam0");
    const Images right = images_of("cam1");
    ASSERT_EQ(left.size(), 4U);
    ASSERT_EQ(right.size(), 5U);
    // date -u -d "2024-05-06 07:08:10" +%s
    EXPECT_EQ(left.begin()->first, 1714979290'250'000'000);
    for (const auto& [time_ns, bytes] : left) EXPECT_TRUE(right.contains(time_ns)) << time_ns;
    EXPECT_EQ(right.at(1714979294'250'000'000), photo(1, 2, "2024:05:06 08:08:16", "75"));
    EXPECT_NE(message_of("camera_clocks_differ").find("3602.500 s ahead"), std::string::npos);
}

// Bursts of two a second whose seconds begin at other moments in the two cameras.
TEST_F(ImportStillsTest, ImagesOfOneSecondAreSpreadOverItAndPairsGetOneTime) {
    for (int i = 0; i < 6; ++i) {
        const std::string date = "2024:05:06 07:08:" + padded(10 + i / 2, 2);
        put(recorded() / "left" / ("I" + padded(i) + ".jpg"), photo(0, i, date, ""));
        put(recorded() / "right" / ("I" + padded(i) + ".jpg"), photo(1, i, date, ""));
    }
    imported(options_for({recorded()}));
    const Images left = images_of("cam0");
    ASSERT_EQ(left.size(), 6U);
    EXPECT_EQ(std::next(left.begin())->first - left.begin()->first, 500'000'000);
    EXPECT_EQ(std::next(left.begin())->second, photo(0, 1, "2024:05:06 07:08:10", ""));
    EXPECT_EQ(images_of("cam1").rbegin()->first, left.rbegin()->first);
}

TEST_F(ImportStillsTest, AListGivesTimesInEveryFormOfTable) {
    std::string rows = "\xef\xbb\xbftime;left;right\r\n";
    for (int i = 0; i < kNumPairs; ++i) {
        put(recorded() / "a" / ("P" + padded(i) + ".png"), png(0, i));
        put(recorded() / "b" / ("Q" + padded(40 - i) + ".png"), png(1, i));
        rows += "1700000000," + std::to_string(i) + ";C:\\dive\\a\\P" + padded(i) +
                ".PNG;C:\\dive\\b\\Q" + padded(40 - i) + "\r\n";
    }
    put(folder_ / "list.csv", rows);
    StillsOptions options = options_for({recorded()});
    options.cameras = {"a", "b"};
    options.times.list = folder_ / "list.csv";
    imported(options);
    expect_pairs();
    put(folder_ / "list.csv", "left,right\nP000000,Q000040\n");
    fs::remove_all(options.out);
    EXPECT_NE(refusal_of(options).find("no column of times"), std::string::npos);
    put(folder_ / "list.csv", "1700000000.5,other\n");
    EXPECT_NE(refusal_of(options).find("names no image"), std::string::npos);
}

// In the form of KITTI's calib.txt, where cameras 2 and 3 are not at one height either.
constexpr const char* kKittiCalibration =
    "P0: 60 0 32 0 0 60 24 0 0 0 1 0\n"
    "P1: 60 0 32 -32.22903919608 0 60 24 0 0 0 1 0\n"
    "P2: 60 0 32 3.6 0 60 24 0.03 0 0 1 0.002\n"
    "P3: 60 0 32 -28.8 0 60 24 0.09 0 0 1 0.001\n";

TEST_F(ImportStillsTest, KittisOdometryHasItsOwnTimesAndCalibration) {
    std::string times;
    for (int i = 0; i < kNumPairs; ++i) {
        times += std::to_string(i) + ".000000e-01\n";
        for (int camera = 0; camera < 4; ++camera)
            put(recorded() / "04" / ("image_" + std::to_string(camera)) / (padded(i) + ".png"),
                png(camera, i));
    }
    put(recorded() / "04" / "times.txt", times);
    put(recorded() / "04" / "calib.txt", kKittiCalibration);
    StillsOptions options = options_for({recorded()});
    options.calibration.clear();
    imported(options);
    const Images right = images_of("cam1");
    ASSERT_EQ(right.size(), static_cast<std::size_t>(kNumPairs));
    EXPECT_EQ(right.at(4 * kPeriod_ns), png(3, 4));
    const auto colour = dive::Dive::open(options.out, folder_.path());
    const Eigen::Isometry3d T = colour->rig().T_imu_cam0.inverse() * colour->rig().T_imu_cam1;
    // Centres: K^-1 p of both projections, subtracted.
    const Eigen::Vector3d left_m((3.6 - 32 * 0.002) / 60, (0.03 - 24 * 0.002) / 60, 0.002);
    const Eigen::Vector3d right_m((-28.8 - 32 * 0.001) / 60, (0.09 - 24 * 0.001) / 60, 0.001);
    EXPECT_LT((T.translation() - (left_m - right_m)).norm(), 1e-9);
    EXPECT_LT((T.linear() - Eigen::Matrix3d::Identity()).norm(), 1e-9);

    options.out = folder_ / "grey";
    options.cameras = {"image_0", "image_1"};
    imported(options);
    const auto grey = dive::Dive::open(options.out, folder_.path());
    EXPECT_NEAR((grey->rig().T_imu_cam0.inverse() * grey->rig().T_imu_cam1).translation().x(),
                0.537150653268,
                1e-9);
}

TEST_F(ImportStillsTest, KittisRawDataIsReadRectified) {
    const fs::path drive = recorded() / "2011_09_26" / "drive_0001_sync";
    std::string stamps;
    for (int i = 0; i < kNumPairs; ++i) {
        stamps += "2023-11-14 22:13:20." + std::to_string(i) + "00000000\n";
        for (const char* camera : {"0", "1"})
            put(drive / (std::string("image_0") + camera) / "data" / (padded(i, 10) + ".png"),
                png(camera[0] - '0', i));
    }
    for (const char* camera : {"image_00", "image_01"})
        put(drive / camera / "timestamps.txt", stamps);
    std::string text = "calib_time: 09-Jan-2012 13:57:47\ncorner_dist: 9.95e-02\n";
    for (const char* camera : {"00", "01"}) {
        text += std::string("S_") + camera + ": 70 50\nK_" + camera + ": 61 0 35 0 61 25 0 0 1\n";
        text +=
            std::string("D_") + camera + ": -0.3 0.2 0.001 0 -0.07\nS_rect_" + camera + ": 64 48\n";
        text += std::string("R_rect_") + camera + ": 1 0 0 0 1 0 0 0 1\n";
        text += std::string("P_rect_") + camera + ": 60 0 32 " + (camera[1] == '0' ? "0" : "-30") +
                " 0 60 24 0 0 0 1 0\n";
    }
    put(recorded() / "2011_09_26" / "calib_cam_to_cam.txt", text);
    StillsOptions options = options_for({recorded()});
    options.calibration.clear();
    imported(options);
    expect_pairs();
    const auto dive = dive::Dive::open(options.out, folder_.path());
    EXPECT_NEAR(dive->rig().cam0.fx_px, 60.0, 1e-12);
    EXPECT_NEAR(
        (dive->rig().T_imu_cam0.inverse() * dive->rig().T_imu_cam1).translation().x(), 0.5, 1e-12);
}

TEST(KittiCalibrationTest, WhatDoesNotDescribeBothCamerasIsNone) {
    EXPECT_TRUE(kitti_cameras(kKittiCalibration, 0, 3, {64, 48}));
    EXPECT_FALSE(kitti_cameras(kKittiCalibration, 0, 4, {64, 48}));
    EXPECT_FALSE(kitti_cameras(kKittiCalibration, 1, 1, {64, 48}));  // no baseline
    for (const char* text :
         {"",
          "P0:",
          "P0: 1 2 3\nP1: 1 2 3\n",
          "P0: 60 0 32 0 0 60 24 0 0 0 1 nan\nP1: 60 0 32 -30 0 60 24 0 0 0 1 0\n",
          "P0: 0 0 0 0 0 0 0 0 0 0 0 0\nP1: 60 0 32 -30 0 60 24 0 0 0 1 0\n"})
        EXPECT_FALSE(kitti_cameras(text, 0, 1, {64, 48})) << text;
}

// EuRoC's layout as spreadsheets write it: seconds, semicolons, an index, and TIFF images.
TEST_F(ImportStillsTest, EurocsLayoutInOtherTablesIsReadWithItsImu) {
    std::string imu = "time [s];wx;wy;wz;ax;ay;az\n";
    for (int i = 0; i < 100; ++i)
        imu += "1700000000," + padded(i * 5, 3) + ";0,01;0,02;0,03;0,1;0,2;9,8\n";
    for (const char* camera : {"cam0", "cam1"}) {
        std::string rows = ",timestamp,filename\n";
        for (int i = 0; i < kNumPairs; ++i) {
            put(recorded() / "mav0" / camera / "data" / ("f" + padded(i) + ".tif"),
                encoded(".tif", made_image(camera[3] - '0', i)));
            rows += std::to_string(i) + "," + std::to_string(kStart_ns + i * kPeriod_ns) + ",f" +
                    padded(i) + ".tif\n";
        }
        put(recorded() / "mav0" / camera / "data.csv", rows);
        put(recorded() / "mav0" / camera / "sensor.yaml", sensor_yaml(camera[3] == '0' ? 0 : 0.1));
    }
    put(recorded() / "mav0" / "imu0" / "data.csv", imu);
    put(recorded() / "mav0" / "imu0" / "sensor.yaml",
        "T_BS:\n  data: [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]\n");
    put(recorded() / "mav0" / "ahrs0" / "data.csv", "");
    StillsOptions options = options_for({recorded()});
    options.calibration.clear();
    EXPECT_EQ(imported(options).num_imu, 100);
    for (const auto& [time_ns, bytes] : images_of("cam1")) {
        const cv::Mat wanted = made_image(1, static_cast<int>((time_ns - kStart_ns) / kPeriod_ns));
        EXPECT_EQ(cv::norm(decoded(bytes), wanted, cv::NORM_INF), 0.0) << time_ns;
    }
    EXPECT_EQ(images_of("cam0").size(), static_cast<std::size_t>(kNumPairs));
    EXPECT_NE(text_of(options.out / "mav0/imu0/data.csv")
                  .find("1700000000495000000,0.01,0.02,0.03,0.1,0.2,9.8\n"),
              std::string::npos);
    EXPECT_NE(message_of("sensor_left_out").find("ahrs0"), std::string::npos);
    options.out = folder_ / "without";
    options.imu = "none";
    EXPECT_EQ(imported(options).num_imu, 0);
}

class StoredImageTest : public ImportStillsTest {
protected:
    static cv::Mat pixels(const std::string& bytes, const PixelOptions& options = {}) {
        const ImageFile file = stored_image(bytes, options);
        return decoded(file.bytes);
    }
    static bool equal(const cv::Mat& a, const cv::Mat& b) {
        return a.size() == b.size() && a.type() == b.type() && cv::norm(a, b, cv::NORM_INF) == 0.0;
    }
    static std::string reason(const std::string& bytes, const PixelOptions& options = {}) {
        try {
            stored_image(bytes, options);
        } catch (const Error& error) {
            return error.what();
        }
        return "";
    }
};

TEST_F(StoredImageTest, EveryFormatKeepsItsPixels) {
    for (const char* extension : {".tif", ".bmp", ".pgm", ".png"})
        EXPECT_TRUE(equal(pixels(encoded(extension, made_image(0, 1))), made_image(0, 1)))
            << extension;
    for (const char* extension : {".tif", ".bmp", ".ppm", ".png"})
        EXPECT_TRUE(
            equal(pixels(encoded(extension, made_image(0, 2, CV_8UC3))), made_image(0, 2, CV_8UC3)))
            << extension;
    for (const char* extension : {".tif", ".pgm", ".png"})
        EXPECT_TRUE(equal(pixels(encoded(extension, made_image(0, 3, CV_16UC1))),
                          made_image(0, 3, CV_16UC1)))
            << extension;
    EXPECT_TRUE(
        equal(pixels(encoded(".tif", made_image(0, 4, CV_16UC3))), made_image(0, 4, CV_16UC3)));
    const std::string jpeg = encoded(".jpg", made_image(0, 5));
    EXPECT_EQ(stored_image(jpeg, {}).bytes, jpeg);
}

TEST_F(StoredImageTest, ValuesOfFewBitsAreMovedUp) {
    cv::Mat low = made_image(0, 1, CV_16UC1);
    low.forEach<std::uint16_t>([](std::uint16_t& value, const int*) { value &= 1023U; });
    const cv::Mat wanted = low * 64;
    EXPECT_TRUE(equal(pixels(encoded(".png", low), {"", 10}), wanted));
    std::string pgm = "P5\n# ten bits\n64 48\n1023\n";
    for (int i = 0; i < low.rows * low.cols; ++i) {
        const auto value = low.at<std::uint16_t>(i / low.cols, i % low.cols);
        pgm += {static_cast<char>(value >> 8U), static_cast<char>(value)};
    }
    EXPECT_TRUE(equal(pixels(pgm), wanted));
    EXPECT_NE(reason(encoded(".png", low), {"", 9}).find("--bits"), std::string::npos);
}

// A mosaic of one colour everywhere is that colour everywhere, whichever the pattern.
TEST_F(StoredImageTest, AMosaicIsInterpolatedByItsPattern) {
    const int bgr[] = {40, 120, 200};
    for (const std::string pattern : {"rggb", "bggr", "gbrg", "grbg"})
        for (const int type : {CV_8UC1, CV_16UC1}) {
            cv::Mat mosaic(48, 64, type);
            for (int y = 0; y < mosaic.rows; ++y)
                for (int x = 0; x < mosaic.cols; ++x) {
                    const char colour = pattern[static_cast<std::size_t>(2 * (y % 2) + x % 2)];
                    const int value = bgr[colour == 'b' ? 0 : colour == 'g' ? 1 : 2];
                    if (type == CV_8UC1)
                        mosaic.at<std::uint8_t>(y, x) = static_cast<std::uint8_t>(value);
                    else
                        mosaic.at<std::uint16_t>(y, x) = static_cast<std::uint16_t>(value << 8);
                }
            const cv::Mat colours = pixels(encoded(".png", mosaic), {pattern, 0});
            ASSERT_EQ(colours.channels(), 3) << pattern;
            const cv::Scalar middle = cv::mean(colours(cv::Rect(8, 8, 40, 30)));
            for (int k = 0; k < 3; ++k)
                EXPECT_NEAR(middle[k], type == CV_8UC1 ? bgr[k] : bgr[k] << 8, 1e-6) << pattern;
        }
    EXPECT_NE(reason(encoded(".png", made_image(0, 0, CV_8UC3)), {"rggb", 0}).find("colours"),
              std::string::npos);
}

TEST_F(StoredImageTest, HostileImagesAreRefusedBeforeTheyAreDecoded) {
    const ExifWriter tiff(ByteOrder::Little);
    std::string bomb = "II*" + std::string(1, '\0') + tiff.number(8, 4) + tiff.number(2, 2);
    for (const std::uint64_t tag : {256, 257})
        bomb += tiff.number(tag, 2) + tiff.number(4, 2) + tiff.number(1, 4) +
                tiff.number(0x7fffffff, 4);
    for (const std::string& bytes : {bomb + std::string(4, '\0'),
                                     std::string("P5 100000 100000 255\n"),
                                     "BM" + std::string(12, '\0') + tiff.number(40, 4) +
                                         tiff.number(60000, 4) + tiff.number(60000, 4)})
        EXPECT_NE(reason(bytes).find("64 million"), std::string::npos);
    for (const std::string& bytes : {std::string(),
                                     std::string("P"),
                                     std::string("P5"),
                                     std::string("P5 0 5 255\n"),
                                     std::string("P5 5 5 0\n"),
                                     std::string("P5 5 5 99999999999999999999\n"),
                                     std::string("P5 -5 5 255\n"),
                                     std::string("BM"),
                                     std::string("II*\0", 4),
                                     std::string("RIFF....WEBP"),
                                     std::string("P5 8 8 255\nxx")})
        EXPECT_NE(reason(bytes), "");
    for (const char* extension : {".tif", ".bmp", ".pgm"}) {
        const std::string whole = encoded(extension, made_image(0, 1));
        for (std::size_t size = 0; size < whole.size(); size += 97)
            reason(whole.substr(0, size));  // an error or fewer pixels, no crash
    }
}

TEST_F(ImportStillsTest, ADamagedImageIsLeftOutAndOtherSizesAreRefused) {
    for (int i = 0; i < kNumPairs; ++i) {
        const std::string name = std::to_string(kStart_ns + i * kPeriod_ns) + ".png";
        put(recorded() / "left" / name, i == 2 ? "damaged" : png(0, i));
        put(recorded() / "right" / name, png(1, i));
    }
    EXPECT_EQ(imported(options_for({recorded()})).num_left, kNumPairs - 1);
    EXPECT_NE(message_of("image_undecodable").find("left out"), std::string::npos);
    fs::remove_all(folder_ / "dive");
    put(recorded() / "left" / (std::to_string(kStart_ns) + ".png"),
        encoded(".png", cv::Mat(50, 64, CV_8UC1, cv::Scalar(0))));
    EXPECT_NE(
        refusal_of(options_for({recorded()})).find("64 x 50 px, its calibration is for 64 x 48"),
        std::string::npos);
    StillsOptions options = options_for({recorded()});
    options.calibration.clear();
    EXPECT_NE(refusal_of(options).find("--calibration"), std::string::npos);
}

TEST_F(ImportStillsTest, UncalibratedImagesBecomeADiveWithoutCalibration) {
    for (int i = 0; i < kNumPairs; ++i) {
        const std::string name = std::to_string(kStart_ns + i * kPeriod_ns) + ".png";
        put(recorded() / "left" / name, png(0, i));
        put(recorded() / "right" / name, png(1, i));
    }
    StillsOptions options = options_for({recorded()});
    options.calibration.clear();
    options.is_uncalibrated = true;
    imported(options);
    expect_pairs();
    for (const char* camera : {"cam0", "cam1"})
        EXPECT_FALSE(fs::exists(options.out / "mav0" / camera / "sensor.yaml")) << camera;
}

}  // namespace
}  // namespace divemesh::recording
