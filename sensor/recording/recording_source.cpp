#include "sensor/recording/recording_source.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <sys/statvfs.h>
#include <tuple>
#include <utility>

#include "schemas/error.hpp"

namespace divemesh::sensor {
namespace {

namespace fs = std::filesystem;

constexpr std::int64_t kAllOfIt = std::numeric_limits<std::int64_t>::max();
constexpr std::chrono::seconds kScanPause{2};  // between searches for a newer dive
constexpr std::size_t kMaxFileNameBytes = 64;

std::string name_of(const fs::path& folder) {
    std::error_code ignored;
    fs::path path = fs::weakly_canonical(folder, ignored);
    if (path.filename() == "mav0" || path.filename().empty()) path = path.parent_path();
    return path.filename().string().substr(0, kMaxFileNameBytes);
}

// Returns one canonical path, wherever the program was started.
fs::path settled(const fs::path& folder) {
    const fs::path path = fs::absolute(folder).lexically_normal();
    return path.filename().empty() ? path.parent_path() : path;
}

// Returns when the recorder last wrote a row; nullopt if it is not a dive.
std::optional<fs::file_time_type> last_row_at(const fs::path& folder) {
    std::error_code failure;
    for (const char* table : {"mav0/cam0/data.csv", "cam0/data.csv"})
        if (const auto time = fs::last_write_time(folder / table, failure); !failure) return time;
    return std::nullopt;
}

// Returns the dives in a folder, the newest last.
std::vector<fs::path> dives_in(const fs::path& folder, std::error_code& failure) {
    if (last_row_at(folder)) return {folder};
    std::vector<std::pair<fs::file_time_type, fs::path>> found;
    for (fs::directory_iterator entry(folder, failure), end; !failure && entry != end;
         entry.increment(failure))
        if (const auto at = last_row_at(entry->path())) found.emplace_back(*at, entry->path());
    std::sort(found.begin(), found.end());
    std::vector<fs::path> dives;
    dives.reserve(found.size());
    for (auto& [at, dive] : found) dives.push_back(std::move(dive));
    return dives;
}

class WatchedFolder : public RecordingSource {
public:
    WatchedFolder(const fs::path& folder, const WatchSettings& settings)
        : folder_(settled(folder)), settings_(settings) {}

    void update(Clock::time_point now) override {
        state_.errors.clear();
        if (now >= scan_at_) scan(now);
        check_storage(folder_);
        if (!scan_error_.empty()) state_.errors.push_back(scan_error_);
        if (dive_)
            update_dive(now);
        else
            state_.is_recording = false;
    }
    std::optional<FrameImages> newest_frame(std::int64_t before_ns) const override {
        return dive_ ? dive_->newest_frame(before_ns) : std::nullopt;
    }
    std::optional<fs::path> take_finished() override { return std::exchange(finished_, {}); }
    std::optional<std::vector<fs::path>> dives() const override { return dives_; }
    fs::path dive_root() const override { return dive_ ? dive_->root() : fs::path(); }

private:
    void scan(Clock::time_point now) {
        scan_at_ = now + kScanPause;
        std::error_code failure;
        auto dives = dives_in(folder_, failure);
        scan_error_ = failure ? folder_.string() + ": " + failure.message() : "";
        dives_.reset();
        if (failure) return;
        if (!dives.empty() && (!dive_ || dive_->folder() != dives.back())) open(dives.back());
        dives_ = std::move(dives);
    }
    void open(const fs::path& dive) {
        if (grew_at_) finished_ = dive_->folder();  // another dive began after it
        const bool is_first = !has_scanned_;
        dive_ = std::make_unique<DiveTail>(dive);
        grew_at_ = {};
        has_scanned_ = true;
        // A dive that is there when the agent starts may be old; one that appears later is being
        // recorded.
        knows_begin_ = !is_first;
    }
    void update_dive(Clock::time_point now) {
        const auto before = dive_->newest_ns();
        if (!dive_->update(kAllOfIt))
            state_.errors.push_back(dive_->folder().string() + ": cam0/data.csv cannot be read");
        const bool grew = dive_->newest_ns() != before;
        if (grew && knows_begin_) grew_at_ = now;
        knows_begin_ = true;
        const auto silence = grew_at_ ? now - *grew_at_ : Clock::duration::max();
        std::error_code ignored;
        const bool is_done = fs::exists(dive_->folder() / kRecordingDone, ignored);
        const bool is_open = grew_at_ && silence < settings_.over_after && !is_done;
        if (grew_at_ && !is_open) finished_ = dive_->folder();
        if (!is_open) grew_at_.reset();
        state_.is_recording = is_open && silence < settings_.silence;
        state_.dive = is_open ? name_of(dive_->folder()) : "";
        state_.open_dive = is_open ? dive_->folder() : fs::path();
        state_.counts = dive_->counts();
        if (!state_.is_recording) state_.counts.frame_rate_hz = state_.counts.imu_rate_hz = {};
    }

    fs::path folder_;
    WatchSettings settings_;
    std::optional<std::vector<fs::path>> dives_;  // nullopt: the folder cannot be read
    std::unique_ptr<DiveTail> dive_;
    Clock::time_point scan_at_ = Clock::time_point::min();
    std::string scan_error_;
    std::optional<Clock::time_point> grew_at_;  // nullopt: it may not be under way
    bool has_scanned_ = false;
    bool knows_begin_ = false;
    std::optional<fs::path> finished_;
};

// Returns the stamps of the first and the last frame.
std::pair<std::int64_t, std::int64_t> span_of(const fs::path& dive) {
    const bool has_mav0 = fs::is_directory(dive / "mav0");
    TableTail table((has_mav0 ? dive / "mav0" : dive) / "cam0" / "data.csv");
    std::int64_t first = 0;
    std::int64_t last = -1;
    const auto note = [&](std::int64_t stamp, auto) {
        if (last < 0) first = stamp;
        last = stamp;
    };
    for (std::int64_t before = -2; before != last;) {  // some megabytes at a time
        before = last;
        if (!table.read(kAllOfIt, note)) break;
    }
    if (last < 0)
        throw Error(ErrorCode::NotFound,
                    dive.string() +
                        " is not the folder of a dive, because cam0/data.csv has no frames: unpack "
                        "an archive first");
    return {first, last};
}

class ReplayedDive : public RecordingSource {
public:
    ReplayedDive(const fs::path& dive, double speed) : dive_(settled(dive)), speed_(speed) {
        std::tie(first_ns_, last_ns_) = span_of(dive);
    }

    void update(Clock::time_point now) override {
        if (!began_at_) began_at_ = now;
        const std::chrono::duration<double, std::nano> since = now - *began_at_;
        const std::int64_t until_ns = first_ns_ + std::llround(since.count() * speed_);
        state_.errors.clear();
        check_storage(dive_.folder());
        if (!dive_.update(std::min(until_ns, last_ns_)))
            state_.errors.push_back(dive_.folder().string() + ": cam0/data.csv cannot be read");
        state_.is_recording = until_ns <= last_ns_;
        if (!state_.is_recording && !is_over_) finished_ = dive_.folder();
        is_over_ = !state_.is_recording;
        state_.dive = is_over_ ? "" : name_of(dive_.folder());
        state_.open_dive = is_over_ ? fs::path() : dive_.folder();
        state_.counts = dive_.counts();
        if (is_over_) state_.counts.frame_rate_hz = state_.counts.imu_rate_hz = {};
    }
    std::optional<FrameImages> newest_frame(std::int64_t before_ns) const override {
        return dive_.newest_frame(before_ns);
    }
    std::optional<fs::path> take_finished() override { return std::exchange(finished_, {}); }
    std::optional<std::vector<fs::path>> dives() const override { return std::vector<fs::path>(); }
    fs::path dive_root() const override { return dive_.root(); }

private:
    DiveTail dive_;
    double speed_;
    std::int64_t first_ns_ = 0;
    std::int64_t last_ns_ = 0;
    std::optional<Clock::time_point> began_at_;
    bool is_over_ = false;
    std::optional<fs::path> finished_;
};

}  // namespace

void RecordingSource::check_storage(const fs::path& folder) {
    struct statvfs status {};
    if (::statvfs(folder.c_str(), &status) == 0)
        state_.storage_free_bytes =
            static_cast<double>(status.f_bavail) * static_cast<double>(status.f_frsize);
    else
        state_.storage_free_bytes.reset();
}

std::unique_ptr<RecordingSource> watch_folder(const fs::path& folder,
                                              const WatchSettings& settings) {
    return std::make_unique<WatchedFolder>(folder, settings);
}

std::unique_ptr<RecordingSource> replay_dive(const fs::path& dive, double speed) {
    return std::make_unique<ReplayedDive>(dive, speed);
}

}  // namespace divemesh::sensor
