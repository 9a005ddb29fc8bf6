#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "schemas/links.hpp"
#include "worker/dive/dive.hpp"
#include "worker/dive/finding_log.hpp"

namespace divemesh::dive {

// A file of a dive.
struct SourceFile {
    std::string path;  // checked by entry_name_problem()
    std::int64_t size_bytes = 0;
    std::int64_t offset_bytes = 0;  // in the pack file of an archive
    std::string sha256;             // "" until computed
};

// Symbolic links of a folder that give no file.
struct UnusedLinks {
    std::int64_t count = 0;
    std::string first;    // its path
    std::string problem;  // what the first one is: "a symbolic link, and these are not followed"
};

// The regular files of a dive in a folder or archive. Reading is thread-safe.
class DiveSource {
public:
    virtual ~DiveSource() = default;

    const std::vector<SourceFile>& files() const { return files_; }  // sorted by path, each once
    const UnusedLinks& unused_links() const { return unused_links_; }

    using Sink = std::function<void(std::span<const char>)>;
    // Passes the file to `sink` in chunks of at most 1 MiB. Throws Error{Unavailable} if it cannot
    // be read.
    virtual void read(const SourceFile& file, const Sink& sink) const = 0;

protected:
    void sort_files();

    std::vector<SourceFile> files_;
    UnusedLinks unused_links_;
};

// Opens a folder. Special files, links that are left out and those that lead nowhere are skipped
// and reported. What Git keeps (.git) is no part of a folder whose links are followed: there they
// lead into it. Throws as Dive::open() does.
std::unique_ptr<DiveSource> open_folder(const std::filesystem::path& folder,
                                        const DiveLimits& limits,
                                        const base::ProgressCallback& progress,
                                        FindingLog& findings,
                                        Links links = Links::LeaveOut);

// Reads the archive once and keeps its files in one unlinked file in `scratch`. Throws
// Error{BadData} that names the entry if one is not a plain file or folder or has a name that
// entry_name_problem() rejects, and Error{BadData} if the archive exceeds the limits.
std::unique_ptr<DiveSource> open_archive(const std::filesystem::path& archive,
                                         const std::filesystem::path& scratch,
                                         const DiveLimits& limits,
                                         const base::ProgressCallback& progress);

// Opens the folder or the archive at `path`. Links in archives are never followed.
std::unique_ptr<DiveSource> open_source(const std::filesystem::path& path,
                                        const std::filesystem::path& scratch,
                                        const DiveLimits& limits,
                                        const base::ProgressCallback& progress,
                                        FindingLog& findings,
                                        Links links = Links::LeaveOut);

}  // namespace divemesh::dive
