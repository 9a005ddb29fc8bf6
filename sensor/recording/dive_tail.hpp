#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <limits>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>

#include "sensor/recording/stamp_window.hpp"
#include "sensor/recording/table_tail.hpp"

namespace divemesh::sensor {

// The images of one moment, as recorded: CV_8UC1 or BGR.
struct FrameImages {
    std::int64_t timestamp_ns = 0;
    cv::Mat left;
    cv::Mat right;  // empty: no image
};

// Counts and values of a recording while it grows.
struct RecordingCounts {
    std::int64_t num_frames = 0;
    std::int64_t num_dropped_frames = 0;  // gaps in the stamps of cam0
    std::optional<double> frame_rate_hz;
    std::optional<double> imu_rate_hz;
    std::optional<std::array<double, 4>> orientation;  // w x y z, of the AHRS
    std::optional<double> depth_m;
};

// A growing dive in EuRoC layout (`folder` contains mav0, or is mav0), up to what is written so far
// or up to a time.
class DiveTail {
public:
    explicit DiveTail(std::filesystem::path folder);

    // Reads the rows stamped until then. Returns false if cam0/data.csv cannot be read.
    bool update(std::int64_t until_ns);
    const RecordingCounts& counts() const { return counts_; }
    std::optional<std::int64_t> newest_ns() const { return frame_stamps_.newest_ns(); }

    // Returns the newest frame stamped before `before_ns` whose images are complete, both if there
    // are two cameras; nullopt if none of the last ones is.
    std::optional<FrameImages> newest_frame(
        std::int64_t before_ns = std::numeric_limits<std::int64_t>::max()) const;

    const std::filesystem::path& folder() const { return folder_; }
    std::filesystem::path root() const { return root_; }  // the folder that contains cam0

private:
    struct Row {
        std::int64_t timestamp_ns = 0;
        std::string file;
    };
    const Row* partner_of(const Row& left) const;
    cv::Mat image(const char* camera, const Row& row) const;

    std::filesystem::path folder_;
    std::filesystem::path root_;
    TableTail cam0_;
    TableTail cam1_;
    TableTail imu_;
    TableTail ahrs_;
    TableTail pressure_;
    std::deque<Row> left_;  // the last ones
    std::deque<Row> right_;
    StampWindow frame_stamps_;
    StampWindow imu_stamps_;
    RecordingCounts counts_;
};

}  // namespace divemesh::sensor
