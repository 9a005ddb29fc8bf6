#include "worker/recording/recorded_kind.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <string>
#include <string_view>

#include "worker/dive/archive_names.hpp"
#include "worker/dive/dive_source.hpp"
#include "worker/recording/image_folders.hpp"
#include "worker/recording/recorded_dive.hpp"
#include "worker/recording/videos_of_recording.hpp"

namespace divemesh::recording {
namespace {

// Beside so many images a video is not the recording, but one of how it was made.
constexpr std::int64_t kImagesPerVideo = 10;

// Counts what the names of files say.
class NameCounts {
public:
    // Returns false when the rest cannot change the answer.
    bool add(std::string_view name) {
        if (is_of_system(name)) return true;
        const std::string path = '/' + std::string(name);
        is_dive_ = path.ends_with("/cam0/sensor.yaml") || path.ends_with("/cam0/data.csv");
        may_be_dive_ |= path.find("/cam0/") != std::string::npos;
        num_images_ += is_image_name(name) ? 1 : 0;
        num_videos_ += is_video_name(name) ? 1 : 0;
        return !is_dive_;
    }

    RecordedKind kind() const {
        using enum RecordedKind::Kind;
        if (is_dive_) return {Dive, true};
        if (num_videos_ > 0 && num_images_ <= kImagesPerVideo * num_videos_) return {Videos};
        if (num_images_ > 0) return {Images, may_be_dive_};
        return {Dive};
    }

private:
    bool is_dive_ = false;
    bool may_be_dive_ = false;
    std::int64_t num_images_ = 0;
    std::int64_t num_videos_ = 0;
};

}  // namespace

RecordedKind recorded_kind(const std::filesystem::path& path) {
    if (is_recording(path)) return {RecordedKind::Kind::Messages};
    NameCounts counts;
    std::error_code unknown;
    if (std::filesystem::is_regular_file(path, unknown)) {
        dive::look_through_archive(
            path, dive::DiveLimits{}, [&](std::string_view name) { return counts.add(name); });
        return counts.kind();
    }
    if (!is_image_folder(path)) return {};
    dive::FindingLog unused;  // opening the folder finds the same
    const auto source = dive::open_folder(path, dive::DiveLimits{}, base::ignore_progress, unused);
    for (const dive::SourceFile& file : source->files())
        if (!counts.add(file.path)) break;
    return counts.kind();
}

}  // namespace divemesh::recording
