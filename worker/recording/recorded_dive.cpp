#include "worker/recording/recorded_dive.hpp"

#include <string>
#include <utility>

#include "worker/dive/entry_name.hpp"
#include "worker/dive/refusal.hpp"
#include "worker/recording/import_recording.hpp"
#include "worker/recording/import_stills.hpp"
#include "worker/recording/import_video.hpp"
#include "worker/recording/recorded_kind.hpp"
#include "worker/recording/videos_of_recording.hpp"

namespace divemesh::recording {
namespace {

namespace fs = std::filesystem;

// Sets where an import writes a dive that keeps no name of a file, and is made again when needed.
template <typename Options>
void write_to(const fs::path& out, Options& options) {
    options.out = out;
    options.naming = Naming::Unnamed;
    options.durability = base::Durability::Unsynced;
}

void import_messages(const fs::path& recording,
                     const fs::path& out,
                     const base::ProgressCallback& progress) {
    ImportOptions options;
    options.recording = recording;
    write_to(out, options);
    RecordingImport(options, progress).write(progress);
}

void import_images(const fs::path& recording,
                   const fs::path& scratch,
                   const fs::path& out,
                   const base::ProgressCallback& progress) {
    StillsOptions options;
    options.folders = {recording};
    options.scratch = scratch;
    write_to(out, options);
    StillsImport(options, progress).write(progress);
}

void import_videos(const fs::path& recording,
                   const fs::path& scratch,
                   const fs::path& out,
                   const base::ProgressCallback& progress) {
    const fs::path unpacked = scratch / "videos";
    fs::create_directories(unpacked);
    VideoImportOptions options = videos_of_recording(recording, unpacked, progress);
    write_to(out, options);
    VideoImport(options, progress).write(progress);
    fs::remove_all(unpacked);  // the images that were chosen are in the dive
}

// Returns whether an import says by this error that the recording does not tell enough.
bool is_of_recording(const Error& error) {
    const ErrorCode code = error.code();
    return code == ErrorCode::BadData || code == ErrorCode::InvalidArgument ||
           code == ErrorCode::TooLarge;
}

const char* contents_of(RecordedKind::Kind kind) {
    switch (kind) {
        case RecordedKind::Kind::Dive: return "a dive";
        case RecordedKind::Kind::Messages: return "messages of ROS";
        case RecordedKind::Kind::Images: return "folders of images";
        case RecordedKind::Kind::Videos: return "videos";
    }
    return "";
}

}  // namespace

bool is_recording(const fs::path& file) {
    std::error_code failure;
    if (!fs::is_regular_file(file, failure)) return false;
    return is_container(InputFile(file));
}

fs::path as_dive(const fs::path& path,
                 const fs::path& scratch,
                 const base::ProgressCallback& progress) {
    using enum RecordedKind::Kind;
    const RecordedKind recorded = recorded_kind(path);
    fs::path out = scratch / "imported";
    try {
        switch (recorded.kind) {
            case Dive: return path;
            case Messages: import_messages(path, out, progress); break;
            case Images: import_images(path, scratch, out, progress); break;
            case Videos: import_videos(path, scratch, out, progress); break;
        }
    } catch (const dive::Refusal&) {
        throw;  // which says what is wrong with the archive
    } catch (const Error& error) {
        if (!is_of_recording(error)) throw;
        if (recorded.may_be_dive) return path;  // which tells what a dive lacks
        const std::string name = dive::printable(path.filename().string());
        throw dive::Refusal(
            "recording_unclear",
            name,
            name + " holds " + contents_of(recorded.kind) +
                " and does not make a dive by itself: " + dive::printable(error.what()),
            "Make a dive of it by divemesh import, which takes what is missing, such as topics or "
            "a calibration, and use that dive: divemesh import " +
                name + " --calibration RIG --out DIVE.");
    }
    return out;
}

}  // namespace divemesh::recording
