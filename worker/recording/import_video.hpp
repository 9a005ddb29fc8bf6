#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "worker/base/observer.hpp"
#include "worker/dive/finding_log.hpp"
#include "worker/recording/dive_writer.hpp"
#include "worker/recording/image_size.hpp"
#include "worker/recording/import_recording.hpp"
#include "worker/recording/paired_video.hpp"
#include "worker/video/indexed_video.hpp"

namespace divemesh::recording {

struct VideoImportOptions {
    // Left and right, or one of both. Of chapters the first one: those after it are found.
    std::vector<std::filesystem::path> videos;
    VideoLayout layout = VideoLayout::TwoFiles;
    double rate_hz = 10.0;           // pairs a second: a diver moves a tenth of the view in between
    std::optional<double> offset_s;  // of a moment: its time in the left video minus in the right
    std::vector<std::filesystem::path> calibration;  // as read_rig() takes them
    bool is_uncalibrated = false;                    // there is none yet: the dive has none
    std::optional<double> metres_per_unit;           // of T in them
    std::string imu;                                 // "none": the telemetry is left out
    std::filesystem::path out;                       // folder of the dive, which must not exist
    Naming naming = Naming::AfterFile;
    base::Durability durability = base::Durability::Synced;
};

// Returns whether a file begins as a video does. Throws as InputFile does.
bool is_video_file(const std::filesystem::path& path);

// Turns one or two videos into a dive in EuRoC layout. Times are those of the left video, from when
// its file says that it was created. Frames that are not chosen are not stored.
class VideoImport {
public:
    // Reads both videos without decoding them. Throws Error{InvalidArgument} if the options
    // contradict the videos, and as read_video() and read_rig() do.
    VideoImport(VideoImportOptions options, const base::ProgressCallback& progress);

    const std::vector<video::IndexedVideo>& videos() const { return videos_; }
    // Writes the dive. Throws Error{BadData} if the videos have no frames of the same time, or none
    // that can be decoded, and as DiveWriter does. A frame that is damaged is left out, with its
    // partner.
    ImportCounts write(const base::ProgressCallback& progress);
    const std::vector<Finding>& findings() const { return findings_.all(); }

private:
    void check_options() const;
    void check_sizes() const;
    ImageSize image_size(const video::IndexedVideo& video) const;
    RigHints hints() const;
    video::ClockOffset find_clock(const base::ProgressCallback& progress);
    std::vector<video::PlannedPair> plan(const video::ClockOffset& clock);
    void report_gaps(const std::vector<video::PlannedPair>& pairs, const video::ClockOffset& clock);
    void write_pairs(const std::vector<video::PlannedPair>& pairs,
                     const video::ClockOffset& clock,
                     DiveWriter& writer,
                     const base::ProgressCallback& progress);
    void write_batch(const std::vector<VideoPair>& batch,
                     const video::ClockOffset& clock,
                     DiveWriter& writer) const;
    void write_imu(const video::ClockOffset& clock, DiveWriter& writer);
    std::optional<types::GeographicPosition> find_position();
    std::int64_t start_ns() const;

    VideoImportOptions options_;
    dive::FindingLog findings_;
    std::vector<video::IndexedVideo> videos_;
    RigFiles rig_;
};

}  // namespace divemesh::recording
