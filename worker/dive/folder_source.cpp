#include <cerrno>
#include <cstring>
#include <dirent.h>
#include <fcntl.h>
#include <string_view>
#include <sys/stat.h>
#include <vector>

#include "schemas/file_descriptor.hpp"
#include "worker/dive/dive_source.hpp"
#include "worker/dive/entry_name.hpp"
#include "worker/dive/refusal.hpp"

namespace divemesh::dive {
namespace {

constexpr std::size_t kChunkBytes = 1 << 20;

std::string last_error() { return std::strerror(errno); }

// Opens `path` below `root` part by part, so that no link is followed.
FileDescriptor open_beneath(int root, std::string_view path) {
    FileDescriptor folder;
    int current = root;
    while (true) {
        const std::size_t slash = path.find('/');
        const std::string part(path.substr(0, slash));
        const bool is_last = slash == std::string_view::npos;
        const int kind = is_last ? O_NONBLOCK : O_DIRECTORY;
        FileDescriptor next(
            ::openat(current, part.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW | kind));
        if (is_last || !next.is_open()) return next;
        folder = std::move(next);
        current = folder.get();
        path.remove_prefix(slash + 1);
    }
}

// Lists a folder without following links.
class Lister {
public:
    Lister(const std::filesystem::path& folder,
           const DiveLimits& limits,
           const base::ProgressCallback& progress,
           FindingLog& findings)
        : folder_(folder), limits_(limits), progress_(progress), findings_(findings) {}

    std::vector<SourceFile> run(int root) {
        list(FileDescriptor(::openat(root, ".", O_RDONLY | O_CLOEXEC | O_DIRECTORY)), "");
        return std::move(files_);
    }

private:
    void list(FileDescriptor folder, const std::string& prefix) {
        const std::unique_ptr<DIR, int (*)(DIR*)> stream(
            folder.is_open() ? ::fdopendir(folder.get()) : nullptr, &::closedir);
        if (!stream)
            throw Error(ErrorCode::Unavailable,
                        "cannot list " + (folder_ / prefix).string() + ": " + last_error());
        const int descriptor = folder.release();  // closedir() closes it
        while (const dirent* entry = ::readdir(stream.get())) {
            const std::string name = entry->d_name;
            if (name == "." || name == "..") continue;
            if (++num_entries_ > limits_.max_entries)
                throw Refusal("folder_too_many_files",
                              printable(folder_.string()),
                              printable(folder_.string()) + " contains more than " +
                                  std::to_string(limits_.max_entries) + " files",
                              "Give the folder of a single dive.");
            if (num_entries_ % 1000 == 0) progress_({});
            accept(descriptor, name, prefix);
        }
    }

    void accept(int folder, const std::string& name, const std::string& prefix) {
        const std::string path = prefix + name;
        struct stat status {};
        if (::fstatat(folder, name.c_str(), &status, AT_SYMLINK_NOFOLLOW) != 0) return;
        if (const auto problem = entry_name_problem(path); !problem.empty()) {
            leave_out(path, "its name " + problem);
        } else if (S_ISDIR(status.st_mode)) {
            list(FileDescriptor(::openat(
                     folder, name.c_str(), O_RDONLY | O_CLOEXEC | O_DIRECTORY | O_NOFOLLOW)),
                 path + "/");
        } else if (S_ISREG(status.st_mode)) {
            files_.push_back({path, status.st_size, 0, ""});
        } else {
            leave_out(path, S_ISLNK(status.st_mode) ? "it is a link" : "it is not a regular file");
        }
    }

    void leave_out(const std::string& path, const std::string& reason) {
        findings_.warning("file_left_out",
                          printable(path),
                          printable(path) + " is ignored: " + reason,
                          "If it belongs to the dive, replace it by a regular file.");
    }

    const std::filesystem::path& folder_;
    const DiveLimits& limits_;
    const base::ProgressCallback& progress_;
    FindingLog& findings_;
    std::int64_t num_entries_ = 0;
    std::vector<SourceFile> files_;
};

class FolderSource : public DiveSource {
public:
    FolderSource(const std::filesystem::path& folder,
                 const DiveLimits& limits,
                 const base::ProgressCallback& progress,
                 FindingLog& findings)
        : folder_(folder), root_(::open(folder.c_str(), O_RDONLY | O_CLOEXEC | O_DIRECTORY)) {
        if (!root_.is_open())
            throw Error(ErrorCode::Unavailable,
                        "cannot open the folder " + folder.string() + ": " + last_error());
        files_ = Lister(folder, limits, progress, findings).run(root_.get());
        sort_files();
    }

    void read(const SourceFile& file, const Sink& sink) const override {
        const FileDescriptor opened = open_beneath(root_.get(), file.path);
        struct stat status {};
        if (!opened.is_open() || ::fstat(opened.get(), &status) != 0 || !S_ISREG(status.st_mode))
            throw Error(ErrorCode::Unavailable,
                        "cannot open " + (folder_ / file.path).string() +
                            ": it changed or became unreadable while the dive was read");
        std::vector<char> chunk(
            std::min<std::size_t>(kChunkBytes, static_cast<std::size_t>(file.size_bytes) + 1));
        std::int64_t left = file.size_bytes;
        while (left > 0) {
            const auto wanted = std::min<std::int64_t>(left, std::ssize(chunk));
            const ssize_t got =
                ::read(opened.get(), chunk.data(), static_cast<std::size_t>(wanted));
            if (got < 0 && errno == EINTR) continue;
            if (got <= 0)
                throw Error(ErrorCode::Unavailable,
                            "cannot read " + (folder_ / file.path).string() + ": " +
                                (got < 0 ? last_error() : "it became shorter while it was read"));
            sink({chunk.data(), static_cast<std::size_t>(got)});
            left -= got;
        }
    }

private:
    std::filesystem::path folder_;
    FileDescriptor root_;
};

}  // namespace

std::unique_ptr<DiveSource> open_folder(const std::filesystem::path& folder,
                                        const DiveLimits& limits,
                                        const base::ProgressCallback& progress,
                                        FindingLog& findings) {
    return std::make_unique<FolderSource>(folder, limits, progress, findings);
}

}  // namespace divemesh::dive
