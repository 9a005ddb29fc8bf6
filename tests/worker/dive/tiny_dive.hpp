#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

namespace divemesh::dive {

// A small complete dive in EuRoC layout: five pairs of 64x48 grey PNGs at 10 Hz, IMU at 200 Hz,
// ground truth. Each test damages one part of it.
class TinyDive {
public:
    static constexpr int kNumFrames = 5;
    static constexpr std::int64_t kFirst_ns = 1'600'000'000'000'000'000;

    explicit TinyDive(std::filesystem::path folder);

    const std::filesystem::path& folder() const { return folder_; }
    std::string read(const std::string& file) const;
    void write(const std::string& file, const std::string& bytes) const;
    void remove(const std::string& file) const;  // a file, or a folder with its contents
    // Replaces the first occurrence of `from` by `to`; throws if there is none.
    void replace(const std::string& file, const std::string& from, const std::string& to) const;

    static std::string image_name(int index);  // "1600000000000000000.png"

private:
    std::filesystem::path folder_;
};

// Returns a sensor.yaml of a camera with this T_BS.
std::string camera_yaml(const std::string& T_body_sensor);
// Returns a PNG of noise; `type` is a type of OpenCV, e.g. CV_8UC1.
std::string png_of_size(int width_px, int height_px, int type);
std::string black_png(int width_px, int height_px);

}  // namespace divemesh::dive
