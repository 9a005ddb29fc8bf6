#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>

namespace divemesh::sensor {

// A recording that a test writes row by row, as a camera does.
class GrowingDive {
public:
    static constexpr std::int64_t kPeriod_ns = 100'000'000;

    explicit GrowingDive(const std::filesystem::path& folder) : root_(folder / "mav0") {
        for (const char* camera : {"cam0", "cam1"}) {
            std::filesystem::create_directories(root_ / camera / "data");
            write(camera, "#timestamp [ns],filename\n");
        }
    }

    // Adds a pair of images of random noise; returns its timestamp.
    std::int64_t add_frame() {
        cv::Mat image(120, 160, CV_8U);
        cv::randu(image, 0, 255);
        std::vector<std::uint8_t> png;
        cv::imencode(".png", image, png);
        const std::string bytes(png.begin(), png.end());
        for (const char* camera : {"cam0", "cam1"}) {
            write_image(camera, bytes);
            write(camera, row());
        }
        const std::int64_t stamp = next_ns_;
        next_ns_ += kPeriod_ns;
        return stamp;
    }
    void skip_frames(int count) { next_ns_ += count * kPeriod_ns; }

    void write(const std::string& camera, const std::string& text) {
        std::ofstream(root_ / camera / "data.csv", std::ios::app) << text;
    }
    void write_image(const std::string& camera, const std::string& bytes) {
        std::ofstream(root_ / camera / "data" / name(), std::ios::binary) << bytes;
    }
    std::string row() const { return std::to_string(next_ns_) + "," + name() + "\n"; }
    std::string name() const { return std::to_string(next_ns_) + ".png"; }

private:
    std::filesystem::path root_;
    std::int64_t next_ns_ = 1'600'000'000'000'000'000;
};

}  // namespace divemesh::sensor
