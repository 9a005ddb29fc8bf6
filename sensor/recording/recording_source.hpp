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

// What the status reports about the recording.
struct RecordingState {
    bool is_recording = false;
    std::string dive;                 // "": no dive is open
    std::filesystem::path open_dive;  // its folder, absolute
    RecordingCounts counts;           // of the newest dive
    std::optional<double> storage_free_bytes;
    std::vector<std::string> errors;  // readable
};

// The recording that is under way, or was just now.
class RecordingSource {
public:
    virtual ~RecordingSource() = default;
    // Reads what is new; takes milliseconds.
    virtual void update(Clock::time_point now) = 0;
    virtual std::optional<FrameImages> newest_frame(
        std::int64_t before_ns = std::numeric_limits<std::int64_t>::max()) const = 0;
    // Returns the folder of a finished dive, each once; for the upload.
    virtual std::optional<std::filesystem::path> take_finished() = 0;
    // Returns the folders of all dives at the last update; nullopt if they could not be read.
    virtual std::optional<std::vector<std::filesystem::path>> dives() const = 0;
    // Returns the folder of the newest dive that contains cam0; empty if there is none.
    virtual std::filesystem::path dive_root() const = 0;

    const RecordingState& state() const { return state_; }

protected:
    void check_storage(const std::filesystem::path& folder);
    RecordingState state_;
};

struct WatchSettings {
    // Time without a new frame after which recording counts as stopped, and after which the dive is
    // finished. A file recording.done in the dive finishes it at once.
    std::chrono::milliseconds silence{3'000};
    std::chrono::milliseconds over_after{60'000};
};

// Watches a folder that is a dive, or that dives are recorded into; the newest dive counts.
std::unique_ptr<RecordingSource> watch_folder(const std::filesystem::path& folder,
                                              const WatchSettings& settings);

// Replays a dive as if it were recorded now, `speed` times as fast. Throws Error{NotFound} if it is
// not a dive.
std::unique_ptr<RecordingSource> replay_dive(const std::filesystem::path& dive, double speed);

}  // namespace divemesh::sensor
