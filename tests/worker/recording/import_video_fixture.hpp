#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "tests/worker/recording/import_fixture.hpp"
#include "tests/worker/video/video_writer.hpp"
#include "worker/recording/import_video.hpp"

namespace divemesh::recording {

inline constexpr std::int64_t kUnknownStart_ns = 1'000'000'000;

inline std::string text_of(const std::filesystem::path& file) {
    std::ifstream stream(file, std::ios::binary);
    std::ostringstream text;
    text << stream.rdbuf();
    return text.str();
}

inline cv::Mat noise_image(int width_px, int height_px, int seed) {
    cv::Mat image(height_px, width_px, CV_8UC3);
    cv::RNG random(static_cast<std::uint64_t>(seed + 1));
    random.fill(image, cv::RNG::UNIFORM, 0, 256);
    return image;
}

// Writes small videos and a calibration, and imports them.
class ImportVideoTest : public ImportFixture<VideoImport, VideoImportOptions> {
protected:
    ImportVideoTest() {
        write_yaml("cam0", "0.0");
        write_yaml("cam1", "0.1");
    }

    void write_yaml(const std::string& camera, const std::string& x_m) {
        std::filesystem::create_directories(folder_ / "rig" / "mav0" / camera);
        std::ofstream(folder_ / "rig" / "mav0" / camera / "sensor.yaml")
            << "T_BS:\n  cols: 4\n  rows: 4\n  data: [1, 0, 0, " << x_m
            << ", 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]\nresolution: [64, 48]\n"
            << "camera_model: pinhole\nintrinsics: [60, 60, 32, 24]\n"
            << "distortion_model: radial-tangential\ndistortion_coefficients: [0, 0, 0, 0]\n";
    }

    void write_imu_yaml() {
        std::filesystem::create_directories(folder_ / "rig" / "mav0" / "imu0");
        std::ofstream(folder_ / "rig" / "mav0" / "imu0" / "sensor.yaml")
            << "T_BS:\n  cols: 4\n  rows: 4\n"
            << "  data: [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]\n"
            << "gyroscope_noise_density: 1.0e-3\ngyroscope_random_walk: 1.0e-5\n"
            << "accelerometer_noise_density: 1.0e-2\naccelerometer_random_walk: 1.0e-4\n";
    }

    // Writes images of a size, numbered from `seed` on, at times in ms.
    std::filesystem::path written(const std::string& name,
                                  const std::vector<std::int64_t>& times_ms,
                                  int seed,
                                  video::WrittenVideo video = {},
                                  const std::vector<std::string>& payloads = {}) {
        video::VideoWriter writer(folder_ / name, video);
        for (std::size_t i = 0; i < payloads.size(); ++i)
            writer.add_gpmf(payloads[i], static_cast<std::int64_t>(1000 * i), 1000);
        for (std::size_t i = 0; i < times_ms.size(); ++i)
            writer.add_frame(
                noise_image(video.width_px, video.height_px, seed + static_cast<int>(i)),
                times_ms[i]);
        writer.finish();
        return folder_ / name;
    }

    VideoImportOptions options_for(const std::vector<std::filesystem::path>& videos) const {
        VideoImportOptions options;
        options.videos = videos;
        options.calibration = {folder_ / "rig"};
        options.out = folder_ / "dive";
        if (videos.size() == 2) options.offset_s = 0.0;
        return options;
    }

    // Imports in place of an earlier dive.
    ImportCounts imported(const VideoImportOptions& options) {
        std::filesystem::remove_all(options.out);
        return ImportFixture::imported(options);
    }

    // Expects an image of the dive to have the pixels of another one.
    void expect_image(const char* camera, std::int64_t time_ns, const cv::Mat& truth) const {
        const auto file =
            folder_ / "dive" / "mav0" / camera / "data" / (std::to_string(time_ns) + ".png");
        const cv::Mat image = cv::imread(file.string(), cv::IMREAD_UNCHANGED);
        ASSERT_EQ(image.size(), truth.size()) << file;
        EXPECT_EQ(cv::norm(image, truth, cv::NORM_INF), 0.0) << file;
    }
};

}  // namespace divemesh::recording
