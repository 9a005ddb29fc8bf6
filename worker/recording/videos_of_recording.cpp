#include "worker/recording/videos_of_recording.hpp"

#include <algorithm>
#include <array>
#include <iterator>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "schemas/error.hpp"
#include "worker/base/atomic_file.hpp"
#include "worker/recording/calibrations_beside.hpp"
#include "worker/recording/camera_sides.hpp"
#include "worker/recording/image_folders.hpp"

namespace divemesh::recording {
namespace {

namespace fs = std::filesystem;

constexpr std::array kExtensions = {".mp4", ".m4v", ".mov", ".mkv", ".avi"};

void copy_file(const ImageFolders& files, const std::string& name, const fs::path& to) {
    base::AtomicFile file(to, base::Durability::Unsynced);
    files.read_all(name, [&](std::span<const char> chunk) {
        file.write({chunk.data(), chunk.size()});
    });
    file.commit();
}

}  // namespace

bool is_video_name(std::string_view name) {
    const std::string lower = lower_case(name);
    return std::any_of(kExtensions.begin(), kExtensions.end(), [&](const char* extension) {
        return lower.ends_with(extension);
    });
}

VideoImportOptions videos_of_recording(const fs::path& recording,
                                       const fs::path& scratch,
                                       const base::ProgressCallback& progress) {
    dive::FindingLog findings;  // about names alone: those of the videos are the import's
    const ImageFolders files({recording}, scratch, findings, progress);
    std::vector<std::string> names;
    std::copy_if(
        files.names().begin(), files.names().end(), std::back_inserter(names), is_video_name);
    const CameraSides sides = find_camera_sides(names, {}, findings);
    if (sides.left.size() != 1 || sides.right.size() != 1)
        throw Error(ErrorCode::BadData,
                    "it has " + std::to_string(sides.left.size()) +
                        " videos of the left camera "
                        "and " +
                        std::to_string(sides.right.size()) + " of the right one");
    const auto calibration = calibrations_beside(files, findings);
    if (calibration.empty())
        throw Error(ErrorCode::BadData,
                    "no calibration lies beside its videos: Kalibr's camchain.yaml, OpenCV's "
                    "files, or another that is read");
    VideoImportOptions options;
    const bool is_folder = fs::is_directory(recording);
    for (const auto& [side, own_name] :
         {std::pair(&sides.left, "left"), std::pair(&sides.right, "right")}) {
        const std::string& name = side->front().name;
        options.videos.push_back(is_folder ? recording / name : scratch / own_name);
        if (!is_folder) copy_file(files, name, options.videos.back());
    }
    for (const CalibrationText& file : calibration) {
        const std::string number = std::to_string(options.calibration.size());
        options.calibration.push_back(scratch / ("calibration-" + number));
        base::write_file(options.calibration.back(), file.bytes, base::Durability::Unsynced);
    }
    return options;
}

}  // namespace divemesh::recording
