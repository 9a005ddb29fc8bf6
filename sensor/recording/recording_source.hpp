#pragma once

#include <chrono>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "sensor/recording/dive_tail.hpp"

namespace divemesh::sensor {

using Clock = std::chrono::steady_clock;

inline constexpr const char* kRecordingDone = "recording.done";  // in the folder of a dive

struct RecordingState {
    bool is_recording = false;
    std::string dive;                 // "": none is open
    std::filesystem::path open_dive;  // the folder of it, absolute
    RecordingCounts counts;           // of the newest dive
    std::optional<double> storage_free_bytes;
    std::vector<std::string> errors;  // for people
};

// What is being recorded, or was just now.
class RecordingSource {
public:
    virtual ~RecordingSource() = default;
    // Looks again; takes milliseconds.
    virtual void update(Clock::time_point now) = 0;
    virtual std::optional<FrameImages> newest_frame(
        std::int64_t before_ns = std::numeric_limits<std::int64_t>::max()) const = 0;
    // The folder of a dive that is over, each once; for the upload.
    virtual std::optional<std::filesystem::path> take_finished() = 0;
    // The folders of all that are there, as it last looked; nothing where that was not possible.
    virtual std::optional<std::vector<std::filesystem::path>> dives() const = 0;
    // Of the newest dive, that cam0 is in; empty: none.
    virtual std::filesystem::path dive_root() const = 0;

    const RecordingState& state() const { return state_; }

protected:
    void check_storage(const std::filesystem::path& folder);
    RecordingState state_;
};

struct WatchSettings {
    // Without a new frame after which nothing is being recorded, and after which the dive is over;
    // the latter at once when the dive holds a file recording.done.
    std::chrono::milliseconds silence{3'000};
    std::chrono::milliseconds over_after{60'000};
};

// A folder that dives are recorded to: one, or one below it for each; the newest counts.
std::unique_ptr<RecordingSource> watch_folder(const std::filesystem::path& folder,
                                              const WatchSettings& settings);

// A dive that was recorded, as if it were now; `speed` times as fast. Throws Error{NotFound} when
// it is none.
std::unique_ptr<RecordingSource> replay_dive(const std::filesystem::path& dive, double speed);

}  // namespace divemesh::sensor
