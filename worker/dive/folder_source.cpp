#include <algorithm>
#include <cerrno>
#include <cstring>
#include <dirent.h>
#include <fcntl.h>
#include <string_view>
#include <sys/stat.h>
#include <utility>
#include <vector>

#include "schemas/file_descriptor.hpp"
#include "worker/dive/dive_source.hpp"
#include "worker/dive/entry_name.hpp"
#include "worker/dive/refusal.hpp"

namespace divemesh::dive {
namespace {

constexpr std::size_t kChunkBytes = 1 << 20;
constexpr std::string_view kVersionControl = ".git";

std::string last_error() { return std::strerror(errno); }

int open_flags(Links links) {
    return O_RDONLY | O_CLOEXEC | (links == Links::Follow ? 0 : O_NOFOLLOW);
}

// Opens `path` below `root` part by part, so that no link is followed that should not be.
FileDescriptor open_beneath(int root, std::string_view path, Links links) {
    FileDescriptor folder;
    int current = root;
    while (true) {
        const std::size_t slash = path.find('/');
        const std::string part(path.substr(0, slash));
        const bool is_last = slash == std::string_view::npos;
        const int kind = is_last ? O_NONBLOCK : O_DIRECTORY;
        FileDescriptor next(::openat(current, part.c_str(), open_flags(links) | kind));
        if (is_last || !next.is_open()) return next;
        folder = std::move(next);
        current = folder.get();
        path.remove_prefix(slash + 1);
    }
}

// Returns where a link points to; "" if it cannot be read.
std::string target_of(int folder, const std::string& link) {
    std::string target(1024, '\0');
    const ssize_t length = ::readlinkat(folder, link.c_str(), target.data(), target.size());
    target.resize(static_cast<std::size_t>(std::max<ssize_t>(length, 0)));
    return target;
}

// Lists a folder, with what its links lead to if they are followed. A folder is not entered a
// second time from within itself, and entry_name_problem() bounds the depth.
class Lister {
public:
    Lister(const std::filesystem::path& folder,
           const DiveLimits& limits,
           const base::ProgressCallback& progress,
           FindingLog& findings,
           Links links)
        : folder_(folder),
          limits_(limits),
          progress_(progress),
          findings_(findings),
          links_(links) {}

    std::vector<SourceFile> run(int root) {
        list(FileDescriptor(::openat(root, ".", O_RDONLY | O_CLOEXEC | O_DIRECTORY)), "");
        return std::move(files_);
    }

    const UnusedLinks& unused_links() const { return unused_links_; }

private:
    using FolderId = std::pair<dev_t, ino_t>;

    void list(FileDescriptor folder, const std::string& prefix) {
        struct stat status {};
        ::fstat(folder.get(), &status);  // list_entries() tells why a folder is not open
        entered_.emplace_back(status.st_dev, status.st_ino);
        list_entries(std::move(folder), prefix);
        entered_.pop_back();
    }

    void list_entries(FileDescriptor folder, const std::string& prefix) {
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
        if (links_ == Links::Follow && name == kVersionControl) return;
        const bool is_link = S_ISLNK(status.st_mode);
        if (is_link && links_ == Links::LeaveOut) return leave_out_link(path);
        if (is_link && ::fstatat(folder, name.c_str(), &status, 0) != 0) {
            const std::string reason = last_error();
            return report_broken(path, target_of(folder, name), reason);
        }
        if (const auto problem = entry_name_problem(path); !problem.empty()) {
            leave_out(path, "its name " + problem);
        } else if (S_ISDIR(status.st_mode) && is_within(status)) {
            leave_out(path, "it is a link to a folder that it lies in");
        } else if (S_ISDIR(status.st_mode)) {
            list(FileDescriptor(::openat(folder, name.c_str(), open_flags(links_) | O_DIRECTORY)),
                 path + "/");
        } else if (S_ISREG(status.st_mode)) {
            files_.push_back({path, status.st_size, 0, ""});
        } else {
            leave_out(path, "it is not a regular file");
        }
    }

    bool is_within(const struct stat& status) const {
        const FolderId id{status.st_dev, status.st_ino};
        return std::find(entered_.begin(), entered_.end(), id) != entered_.end();
    }

    void leave_out_link(const std::string& path) {
        count_unused(path, "a symbolic link, and these are not followed here");
        leave_out(path, "it is a link");
    }

    void report_broken(const std::string& path,
                       const std::string& target,
                       const std::string& reason) {
        const std::string problem =
            "a link to " + printable(target) + ", which cannot be read: " + reason;
        count_unused(path, problem);
        findings_.warning("link_broken",
                          printable(path),
                          printable(path) + " is " + problem,
                          "Fetch the file that it stands for (git annex get, datalad get, mount "
                          "the disk), or replace the link by the file.");
    }

    void count_unused(const std::string& path, const std::string& problem) {
        if (unused_links_.count++ > 0) return;
        unused_links_.first = path;
        unused_links_.problem = problem;
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
    const Links links_;
    std::int64_t num_entries_ = 0;
    std::vector<FolderId> entered_;  // from the root to the folder that is listed
    UnusedLinks unused_links_;
    std::vector<SourceFile> files_;
};

class FolderSource : public DiveSource {
public:
    FolderSource(const std::filesystem::path& folder,
                 const DiveLimits& limits,
                 const base::ProgressCallback& progress,
                 FindingLog& findings,
                 Links links)
        : folder_(folder),
          links_(links),
          root_(::open(folder.c_str(), O_RDONLY | O_CLOEXEC | O_DIRECTORY)) {
        if (!root_.is_open())
            throw Error(ErrorCode::Unavailable,
                        "cannot open the folder " + folder.string() + ": " + last_error());
        Lister lister(folder, limits, progress, findings, links);
        files_ = lister.run(root_.get());
        unused_links_ = lister.unused_links();
        sort_files();
    }

    void read(const SourceFile& file, const Sink& sink) const override {
        const FileDescriptor opened = open_beneath(root_.get(), file.path, links_);
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
    Links links_;
    FileDescriptor root_;
};

}  // namespace

std::unique_ptr<DiveSource> open_folder(const std::filesystem::path& folder,
                                        const DiveLimits& limits,
                                        const base::ProgressCallback& progress,
                                        FindingLog& findings,
                                        Links links) {
    return std::make_unique<FolderSource>(folder, limits, progress, findings, links);
}

}  // namespace divemesh::dive
