#include "worker/recording/recorded_dive.hpp"

#include <utility>

#include "worker/dive/entry_name.hpp"
#include "worker/dive/refusal.hpp"
#include "worker/recording/import_recording.hpp"

namespace divemesh::recording {

bool is_recording(const std::filesystem::path& file) {
    std::error_code failure;
    if (!std::filesystem::is_regular_file(file, failure)) return false;
    return is_container(InputFile(file));
}

std::filesystem::path as_dive(const std::filesystem::path& path,
                              const std::filesystem::path& scratch,
                              const base::ProgressCallback& progress) {
    if (!is_recording(path)) return path;
    ImportOptions options;
    options.recording = path;
    options.out = scratch / "imported";
    options.naming = Naming::Unnamed;
    options.durability = base::Durability::Unsynced;
    try {
        RecordingImport(options, progress).write(progress);
    } catch (const Error& error) {
        const ErrorCode code = error.code();
        if (code != ErrorCode::BadData && code != ErrorCode::InvalidArgument &&
            code != ErrorCode::TooLarge)
            throw;
        throw dive::Refusal("recording_unclear",
                            dive::printable(path.filename().string()),
                            std::string("the recording does not make a dive by itself: ") +
                                dive::printable(error.what()),
                            "Turn it into a dive by divemesh import, which takes topics and a "
                            "calibration, and use that dive.");
    }
    return options.out;
}

}  // namespace divemesh::recording
