#include "worker/dive/dive_source.hpp"

#include <algorithm>

#include "worker/dive/entry_name.hpp"
#include "worker/dive/refusal.hpp"

namespace divemesh::dive {

void DiveSource::sort_files() {
    std::sort(files_.begin(), files_.end(), [](const SourceFile& a, const SourceFile& b) {
        return a.path < b.path;
    });
}

std::unique_ptr<DiveSource> open_source(const std::filesystem::path& path,
                                        const std::filesystem::path& scratch,
                                        const DiveLimits& limits,
                                        const base::ProgressCallback& progress,
                                        FindingLog& findings,
                                        Links links) {
    std::error_code problem;
    const auto status = std::filesystem::status(path, problem);
    if (!std::filesystem::exists(status))
        throw Error(ErrorCode::NotFound,
                    "there is no file or folder " + path.string() + ": check the path");
    if (std::filesystem::is_directory(status))
        return open_folder(path, limits, progress, findings, links);
    if (!std::filesystem::is_regular_file(status))
        throw Refusal("not_an_archive",
                      printable(path.string()),
                      printable(path.string()) + " is neither a folder nor a regular file",
                      "Give the folder or the archive of a dive.");
    return open_archive(path, scratch, limits, progress);
}

}  // namespace divemesh::dive
