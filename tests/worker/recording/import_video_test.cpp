#include "worker/recording/import_video.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>

#include "schemas/error.hpp"
#include "tests/worker/recording/import_video_fixture.hpp"
#include "tests/worker/video/gpmf_writer.hpp"
#include "worker/dive/dive_json.hpp"
#include "worker/dive/sensor_tables.hpp"

namespace divemesh::recording {
namespace {

namespace fs = std::filesystem;

TEST_F(ImportVideoTest, LosslessVideosAreDivesOfTheSamePixelsAtTheirTimes) {
    video::WrittenVideo left;
    left.creation_time = "2026-05-01T10:00:00.000000Z";
    constexpr std::int64_t kCreated_ns = 1'777'629'600'000'000'000;
    auto options = options_for({written("l.mkv", {0, 100, 200, 300, 410}, 0, left),
                                written("r.mkv", {3, 104, 201, 299, 400}, 50)});
    options.offset_s = 0.1;  // the right one began 100 ms later
    const ImportCounts counts = imported(options);
    EXPECT_EQ(counts.num_left, 4);
    EXPECT_EQ(counts.num_right, 4);
    const std::int64_t left_ms[] = {100, 200, 300, 410};
    const std::int64_t right_ms[] = {103, 204, 301, 399};
    for (int i = 0; i < 4; ++i) {
        expect_image("cam0", kCreated_ns + 1'000'000 * left_ms[i], noise_image(64, 48, 1 + i));
        expect_image("cam1", kCreated_ns + 1'000'000 * right_ms[i], noise_image(64, 48, 50 + i));
    }
    EXPECT_TRUE(has_code("video_gaps"));
    const auto info = nlohmann::json::parse(text_of(options.out / "dive.json"));
    EXPECT_EQ(info["name"], "l");
    EXPECT_EQ(info["imported_from"]["files"][1]["file"], "r.mkv");
    EXPECT_EQ(info["imported_from"]["files"][1]["size_bytes"], fs::file_size(folder_ / "r.mkv"));
}

TEST_F(ImportVideoTest, OneVideoOfBothCamerasIsCutInHalves) {
    for (const auto layout : {VideoLayout::SideBySide, VideoLayout::OverUnder}) {
        const bool is_wide = layout == VideoLayout::SideBySide;
        video::WrittenVideo both;
        both.width_px = is_wide ? 128 : 64;
        both.height_px = is_wide ? 48 : 96;
        auto options = options_for({written("b.mkv", {0, 100}, 0, both)});
        options.layout = layout;
        EXPECT_EQ(imported(options).num_right, 2);
        const cv::Mat image = noise_image(both.width_px, both.height_px, 1);
        const std::int64_t time_ns = kUnknownStart_ns + 100'000'000;
        expect_image("cam0", time_ns, image(cv::Rect(0, 0, 64, 48)));
        expect_image("cam1", time_ns, image(cv::Rect(is_wide ? 64 : 0, is_wide ? 0 : 48, 64, 48)));
    }
}

TEST_F(ImportVideoTest, UncalibratedVideosBecomeADiveWithoutCalibration) {
    auto options = options_for({written("l.mkv", {0, 100}, 0), written("r.mkv", {0, 100}, 50)});
    options.offset_s = 0.0;
    options.calibration.clear();
    options.is_uncalibrated = true;
    EXPECT_EQ(imported(options).num_right, 2);
    expect_image("cam1", kUnknownStart_ns + 100'000'000, noise_image(64, 48, 51));
    EXPECT_FALSE(fs::exists(options.out / "mav0" / "cam0" / "sensor.yaml"));
}

TEST_F(ImportVideoTest, FramesOfMotionJpegAreStoredAsTheyAre) {
    video::WrittenVideo video;
    video.codec = "mjpeg";
    video.pixel_format = "yuvj420p";
    const auto options = options_for(
        {written("l.avi", {0, 33, 66}, 0, video), written("r.avi", {0, 33, 66}, 9, video)});
    EXPECT_GE(imported(options).num_left, 1);
    const std::string file = text_of(options.out / "mav0" / "cam0" / "data" / "1000000000.jpg");
    ASSERT_FALSE(file.empty());
    EXPECT_NE(text_of(folder_ / "l.avi").find(file), std::string::npos);
}

TEST_F(ImportVideoTest, TheTelemetryOfAGoProIsTheImu) {
    video::WrittenVideo gopro;
    gopro.has_gpmf = true;
    std::vector<std::string> payloads;
    for (int k = 0; k < 3; ++k) {
        std::vector<int> gyro;
        std::vector<int> accel;
        for (int i = 0; i < 200; ++i) gyro.insert(gyro.end(), {10, 20, 200 * k + i});
        for (int i = 0; i < 200; ++i) accel.insert(accel.end(), {981, 0, 0});
        const auto num = static_cast<std::uint32_t>(200 * (k + 1));
        payloads.push_back(video::device(video::sensor_stream("GYRO", 100, "YxZ", num, gyro) +
                                         video::sensor_stream("ACCL", 100, "ZXY", num, accel)));
    }
    std::vector<std::int64_t> times_ms;
    for (int i = 0; i < 30; ++i) times_ms.push_back(100 * i);
    const auto left = written("l.mov", times_ms, 0, gopro, payloads);
    const auto right = written("r.mov", times_ms, 40);
    EXPECT_EQ(imported(options_for({left, right})).num_imu, 0);
    EXPECT_TRUE(has_code("imu_left_out"));
    write_imu_yaml();
    const auto options = options_for({left, right});
    VideoImportOptions without = options;
    without.imu = "none";
    without.out = folder_ / "without";
    EXPECT_EQ(imported(without).num_imu, 0);
    EXPECT_FALSE(has_code("imu_left_out"));
    EXPECT_GE(imported(options).num_imu, 599);
    dive::FindingLog findings;
    const auto imu =
        dive::parse_imu(text_of(options.out / "mav0" / "imu0" / "data.csv"), "imu", findings);
    for (const types::ImuSample& sample : imu) {
        const double number = 100.0 * sample.angular_velocity_imu.z();
        EXPECT_NEAR(static_cast<double>(sample.timestamp_ns - kUnknownStart_ns), 5e6 * number, 1e5);
        EXPECT_NEAR(sample.angular_velocity_imu.x(), -0.2, 1e-12);
        EXPECT_NEAR(sample.angular_velocity_imu.y(), 0.1, 1e-12);
        EXPECT_NEAR(sample.acceleration_imu.z(), 9.81, 1e-12);
    }
    // The right camera's alone, by the left clock.
    auto swapped = options_for({right, left});
    swapped.offset_s = 0.5;
    imported(swapped);
    const auto later =
        dive::parse_imu(text_of(options.out / "mav0" / "imu0" / "data.csv"), "imu", findings);
    EXPECT_EQ(later.front().timestamp_ns - imu.front().timestamp_ns, 500'000'000);
}

TEST_F(ImportVideoTest, TheShiftOfKalibrPutsTheTelemetryOnTheClockOfTheImages) {
    video::WrittenVideo gopro;
    gopro.has_gpmf = true;
    std::vector<int> numbers;
    for (int i = 0; i < 200; ++i) numbers.insert(numbers.end(), {i + 1, 0, 0});
    const std::string payload = video::device(video::sensor_stream("GYRO", 1, "XYZ", 200, numbers) +
                                              video::sensor_stream("ACCL", 1, "XYZ", 200, numbers));
    auto options = options_for(
        {written("l.mov", {0, 100, 200}, 0, gopro, {payload}), written("r.mov", {0, 100, 200}, 9)});
    options.calibration = {folder_ / "camchain.yaml"};
    dive::FindingLog findings;
    for (const auto& [shift, shift_ns] :
         {std::pair("0.0123", 12'300'000), std::pair("-0.5", -500'000'000), std::pair("0.0", 0)}) {
        std::ofstream(options.calibration[0]) << small_camchain(shift);
        imported(options);
        EXPECT_EQ(has_code("calibration_time_offset"), shift_ns != 0);
        const auto imu =
            dive::parse_imu(text_of(options.out / "mav0" / "imu0" / "data.csv"), "imu", findings);
        ASSERT_GT(imu.size(), 190U);
        EXPECT_EQ(imu[0].timestamp_ns, kUnknownStart_ns - shift_ns);
    }
    VideoImportOptions without = options;
    without.imu = "none";
    std::ofstream(options.calibration[0]) << small_camchain("0.1");
    imported(without);
    EXPECT_FALSE(has_code("calibration_time_offset"));
}

TEST_F(ImportVideoTest, FixesOfTheGpsAreThePositionOfTheDive) {
    video::WrittenVideo gopro;
    gopro.has_gpmf = true;
    const std::string fixes =
        video::gps5_stream(3, 150, {{13.1912, -59.6413}, {13.1913, -59.6413}, {13.1914, -59.6412}});
    const std::string none = video::gps5_stream(0, 9999, {{0.0, 0.0}});
    const auto left = written("l.mov", {0, 100}, 0, gopro, {video::device(fixes)});
    const auto right = written("r.mov", {0, 100}, 9, gopro, {video::device(none)});
    // The camera that has a fix states the position, and the dive reads it.
    for (const auto& videos : {std::vector{left, right}, std::vector{right, left}}) {
        imported(options_for(videos));
        const std::string json = text_of(folder_ / "dive" / "dive.json");
        dive::FindingLog findings;
        const auto position = dive::parse_dive_info(json, findings).position;
        ASSERT_TRUE(position);
        EXPECT_EQ(position->latitude_deg, 13.1913);
        EXPECT_EQ(position->longitude_deg, -59.6413);
        EXPECT_FALSE(position->x_azimuth_deg);
        ASSERT_TRUE(has_code("position_by_gps"));
        EXPECT_EQ(findings.all().back().code, "position_by_gps");
        EXPECT_NE(findings.all().back().message.find("median of 3 fixes"), std::string::npos);
        EXPECT_NE(findings.all().back().message.find("within 11.1 m"), std::string::npos)
            << findings.all().back().message;
    }
    imported(options_for({right, right}));
    EXPECT_FALSE(has_code("position_by_gps"));
    EXPECT_EQ(text_of(folder_ / "dive" / "dive.json").find("position"), std::string::npos);
}

TEST_F(ImportVideoTest, TheRateChoosesPairs) {
    std::vector<std::int64_t> times_ms;
    for (int i = 0; i < 60; ++i) times_ms.push_back(33 * i);
    auto options = options_for({written("l.mkv", times_ms, 0), written("r.mkv", times_ms, 70)});
    options.rate_hz = 5.0;
    EXPECT_EQ(imported(options).num_left, 10);
    options.rate_hz = 100.0;
    EXPECT_EQ(imported(options).num_left, 60);
}

TEST_F(ImportVideoTest, ACutVideoIsUsedUpToTheCut) {
    std::vector<std::int64_t> times_ms;
    for (int i = 0; i < 60; ++i) times_ms.push_back(100 * i);
    const auto left = written("l.mkv", times_ms, 0);
    const auto right = written("r.mkv", times_ms, 70);
    fs::resize_file(right, fs::file_size(right) / 2);
    const ImportCounts counts = imported(options_for({left, right}));
    EXPECT_NEAR(static_cast<double>(counts.num_left), 30.0, 3.0);
    EXPECT_TRUE(has_code("recording_cut"));
    EXPECT_TRUE(has_code("video_unpaired"));
}

TEST_F(ImportVideoTest, WhatCannotBeIsRefusedWithWhatToDo) {
    video::WrittenVideo wide;
    wide.width_px = 128;
    const auto left = written("l.mkv", {0, 100}, 0);
    const auto right = written("r.mkv", {0, 100}, 9);
    const auto other = written("o.mkv", {0, 100}, 9, wide);
    std::ofstream(folder_ / "text.mkv") << "no video at all";
    const std::vector<std::function<void(VideoImportOptions&)>> faults = {
        [&](VideoImportOptions& o) { o.videos = {left}; },
        [&](VideoImportOptions& o) {
            o.videos = {left, right, right};
        },
        [&](VideoImportOptions& o) { o.layout = VideoLayout::SideBySide; },
        [&](VideoImportOptions& o) { o.videos = {left}, o.layout = VideoLayout::OverUnder; },
        [&](VideoImportOptions& o) { o.calibration.clear(); },
        [&](VideoImportOptions& o) { o.calibration = {folder_ / "missing"}; },
        [&](VideoImportOptions& o) { o.videos[1] = other; },
        [&](VideoImportOptions& o) { o.videos[1] = folder_ / "text.mkv"; },
        [&](VideoImportOptions& o) { o.videos[1] = folder_ / "missing.mkv"; },
        [&](VideoImportOptions& o) { o.imu = "/imu/data"; },
        [&](VideoImportOptions& o) { o.rate_hz = 0.0; },
        [&](VideoImportOptions& o) { o.rate_hz = std::nan(""); },
        [&](VideoImportOptions& o) { o.rate_hz = 1e9; },
        [&](VideoImportOptions& o) { o.offset_s = std::nan(""); },
        [&](VideoImportOptions& o) { o.offset_s = 1e300; },
        [&](VideoImportOptions& o) { o.offset_s = 100.0; }};
    for (std::size_t i = 0; i < faults.size(); ++i) {
        VideoImportOptions options = options_for({left, right});
        faults[i](options);
        EXPECT_GT(refusal_of(options).size(), 40U) << i;
    }
}

TEST_F(ImportVideoTest, AFolderThatIsNotEmptyStaysAsItIs) {
    const auto options =
        options_for({written("l.mkv", {0, 100}, 0), written("r.mkv", {0, 100}, 9)});
    fs::create_directories(options.out);
    std::ofstream(options.out / "mine") << "x";
    VideoImport import(options, base::ignore_progress);
    EXPECT_THROW(import.write(base::ignore_progress), Error);
    EXPECT_EQ(text_of(options.out / "mine"), "x");
}

}  // namespace
}  // namespace divemesh::recording
