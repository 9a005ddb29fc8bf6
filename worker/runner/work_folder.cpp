#include "worker/runner/work_folder.hpp"

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fcntl.h>
#include <stdlib.h>
#include <string>
#include <sys/file.h>

#include "schemas/error.hpp"

namespace divemesh::runner {
namespace {

constexpr const char* kLockName = "lock";
constexpr const char* kNamePrefix = "worker.";

FileDescriptor open_lock(const std::filesystem::path& folder, int flags) {
    return FileDescriptor(open((folder / kLockName).c_str(), flags | O_CLOEXEC | O_NOFOLLOW, 0600));
}

// Removes folders of processes that have ended. A folder that can be locked belongs to no running
// process, as it gets its final name only after it is locked.
void remove_leftovers(const std::filesystem::path& common) {
    std::error_code ignored;
    for (const auto& entry : std::filesystem::directory_iterator(common, ignored)) {
        if (!entry.path().filename().string().starts_with(kNamePrefix)) continue;
        const FileDescriptor lock = open_lock(entry.path(), O_RDWR);
        if (lock.is_open() && flock(lock.get(), LOCK_EX | LOCK_NB) == 0)
            std::filesystem::remove_all(entry.path(), ignored);
    }
}

}  // namespace

WorkFolder::WorkFolder(const std::filesystem::path& common) {
    std::error_code failure;
    std::filesystem::create_directories(common, failure);
    remove_leftovers(common);
    std::string unlocked = (common / "new.XXXXXX").string();
    if (mkdtemp(unlocked.data()) == nullptr)
        throw Error(
            ErrorCode::Unavailable,
            "cannot create a work folder in " + common.string() + ": " + std::strerror(errno));
    lock_ = open_lock(unlocked, O_RDWR | O_CREAT);
    path_ = common / (kNamePrefix + unlocked.substr(unlocked.size() - 6));
    if (!lock_.is_open() || flock(lock_.get(), LOCK_EX | LOCK_NB) != 0 ||
        rename(unlocked.c_str(), path_.c_str()) != 0)
        throw Error(ErrorCode::Unavailable, "cannot lock " + path_.string());
}

WorkFolder::~WorkFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
}

}  // namespace divemesh::runner
