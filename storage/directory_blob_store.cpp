#include "storage/directory_blob_store.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <fcntl.h>
#include <stdio.h>
#include <sys/stat.h>
#include <unistd.h>
#include <vector>

#include "schemas/error.hpp"
#include "storage/blob_key.hpp"
#include "storage/directory_files.hpp"
#include "storage/fault_point.hpp"
#include "storage/file_reader.hpp"
#include "storage/ids.hpp"
#include "storage/upload_stage.hpp"

namespace divemesh::storage {
namespace {

namespace fs = std::filesystem;
constexpr std::size_t kCopyBytes = 1 << 20;
constexpr std::chrono::hours kTemporaryFilesLive{24};
constexpr const char* kDataIdName = "data-id";
constexpr std::size_t kMaxDataIdBytes = 128;

class DirectoryBlobStore : public BlobStore {
public:
    DirectoryBlobStore(const std::string& folder, Opening opening)
        : folder_(checked(folder, opening)),
          blobs_(make_area("blobs")),
          stage_(make_area("staged")),
          temporary_(make_area("tmp")) {
        remove_old_temporary_files();
    }

    std::unique_ptr<StagedBlob> open_staged(const std::string& key,
                                            std::int64_t num_durable_bytes) override {
        return stage_.open(key, num_durable_bytes);
    }
    std::int64_t staged_size_bytes(const std::string& key) override {
        return stage_.size_bytes(key);
    }
    std::unique_ptr<BlobReader> read_staged(const std::string& key) override {
        return stage_.read(key);
    }
    void remove_staged(const std::string& key) override { stage_.remove(key); }
    void commit_staged(const std::string& staged_key, const std::string& key) override;

    void put_file(const std::string& key, const fs::path& file) override;
    std::unique_ptr<BlobReader> open(const std::string& key) override {
        FileDescriptor file = find(key);
        if (!file.is_open()) throw_missing(key);
        return read_open_file(std::move(file));
    }
    fs::path local_copy(const std::string& key, const fs::path&, const std::string&) override {
        if (!exists(key)) throw_missing(key);
        return folder_ / "blobs" / key;
    }
    bool exists(const std::string& key) override { return find(key).is_open(); }
    void remove(const std::string& key) override { remove_file(blobs_, key); }
    void remove_prefix(const std::string& prefix) override;
    std::vector<std::string> children(const std::string& prefix) override;
    std::int64_t free_bytes() override { return free_bytes_of(blobs_); }
    std::string data_id() override;
    void set_data_id(const std::string& id) override;
    std::string location() const override { return fs::absolute(folder_).string(); }

private:
    static fs::path checked(const fs::path& folder, Opening opening);
    FileDescriptor make_area(const std::string& name) const { return make_folder(folder_ / name); }
    void remove_old_temporary_files() const;
    void publish(const FileDescriptor& from, const std::string& name, const std::string& key);

    FileDescriptor find(const std::string& key) const {
        const auto parts = split_key(key);
        return open_file(open_parent(blobs_, parts, false), parts.back(), O_RDONLY);
    }
    [[noreturn]] static void throw_missing(const std::string& key) {
        throw Error(ErrorCode::NotFound, "no stored data " + key);
    }

    fs::path folder_;
    FileDescriptor blobs_;
    UploadStage stage_;
    FileDescriptor temporary_;
};

// Removes what killed copies left behind.
void DirectoryBlobStore::remove_old_temporary_files() const {
    std::error_code ignored;
    const auto limit = fs::file_time_type::clock::now() - kTemporaryFilesLive;
    for (const auto& entry : fs::directory_iterator(folder_ / "tmp", ignored))
        if (entry.last_write_time(ignored) < limit) fs::remove(entry.path(), ignored);
}

void DirectoryBlobStore::commit_staged(const std::string& staged_key, const std::string& key) {
    const auto parts = split_key(staged_key);
    const FileDescriptor parent = open_parent(stage_.folder(), parts, false);
    const FileDescriptor file = open_file(parent, parts.back(), O_RDONLY);
    if (!file.is_open()) {
        const FileDescriptor committed = open_parent(blobs_, split_key(key), false);
        if (!exists(key)) throw_missing(staged_key);
        sync(committed);  // committed before, and then killed, or told that this failed
        return;
    }
    sync(file);
    publish(parent, parts.back(), key);
    sync(parent);
}

void DirectoryBlobStore::put_file(const std::string& key, const fs::path& file) {
    split_key(key);
    const FileDescriptor source(::open(file.c_str(), O_RDONLY | O_NOFOLLOW | O_CLOEXEC));
    if (!source.is_open()) throw_errno("opening " + file.string());
    const std::string name = random_hex(16);
    try {
        const FileDescriptor copy = open_file(temporary_, name, O_WRONLY | O_CREAT | O_EXCL);
        std::vector<char> buffer(kCopyBytes);
        for (;;) {
            const auto n = ::read(source.get(), buffer.data(), buffer.size());
            if (n < 0 && errno == EINTR) continue;
            if (n < 0) throw_errno("reading " + file.string());
            if (n == 0) break;
            write_all(copy, {buffer.data(), static_cast<std::size_t>(n)}, key);
        }
        sync(copy);
        publish(temporary_, name, key);
    } catch (...) {
        unlinkat(temporary_.get(), name.c_str(), 0);
        throw;
    }
}

// Creates the blob: a rename, made durable.
void DirectoryBlobStore::publish(const FileDescriptor& from,
                                 const std::string& name,
                                 const std::string& key) {
    const auto parts = split_key(key);
    const FileDescriptor parent = open_parent(blobs_, parts, true);
    fault_point();
    if (renameat(from.get(), name.c_str(), parent.get(), parts.back().c_str()) != 0)
        throw_errno("publishing " + key);
    sync(parent);
}

std::vector<std::string> DirectoryBlobStore::children(const std::string& prefix) {
    const std::string folder = folder_of_prefix(prefix);
    std::vector<std::string> names;
    std::error_code missing;
    for (const auto& entry : fs::directory_iterator(folder_ / "blobs" / folder, missing))
        names.push_back(entry.path().filename().string());
    std::sort(names.begin(), names.end());
    return names;
}

void DirectoryBlobStore::remove_prefix(const std::string& prefix) {
    const std::string folder = folder_of_prefix(prefix);
    const auto parts = split_key(folder);
    const FileDescriptor parent = open_parent(blobs_, parts, false);
    if (!parent.is_open()) return;
    std::error_code failure;
    fs::remove_all(folder_ / "blobs" / folder, failure);  // follows no symbolic link
    if (failure)
        throw Error(ErrorCode::Unavailable, "removing " + prefix + ": " + failure.message());
    sync(parent);
}

// Returns the folder. Throws if it is no store and may not become one.
fs::path DirectoryBlobStore::checked(const fs::path& folder, Opening opening) {
    std::error_code failure;
    if (opening == Opening::ExistingOnly && !fs::is_directory(folder / "blobs", failure))
        throw Error(ErrorCode::Unavailable,
                    "there is no blob store in " + fs::absolute(folder).string() +
                        ": mount its disk, or give the --blobs of the server");
    return folder;
}

// Reads by the path, so that a disk that was mounted or unmounted meanwhile is noticed.
std::string DirectoryBlobStore::data_id() {
    struct stat opened {};
    struct stat present {};
    if (fstat(blobs_.get(), &opened) != 0) throw_errno("looking for the blobs");
    if (::stat((folder_ / "blobs").c_str(), &present) == 0 &&
        (opened.st_dev != present.st_dev || opened.st_ino != present.st_ino))
        throw Error(ErrorCode::Unavailable,
                    "the disk of " + fs::absolute(folder_).string() +
                        " was mounted again since this process opened it: restart the process");
    const FileDescriptor file(::open((folder_ / kDataIdName).c_str(), O_RDONLY | O_CLOEXEC));
    if (!file.is_open() && (errno == ENOENT || errno == ENOTDIR)) return "";
    if (!file.is_open()) throw_errno("opening " + (folder_ / kDataIdName).string());
    std::array<char, kMaxDataIdBytes> text{};
    const auto n = ::read(file.get(), text.data(), text.size());
    if (n < 0) throw_errno("reading " + (folder_ / kDataIdName).string());
    return {text.begin(), std::find(text.begin(), text.begin() + n, '\n')};
}

void DirectoryBlobStore::set_data_id(const std::string& id) {
    const FileDescriptor folder = open_folder(folder_.string());
    const std::string name = std::string(kDataIdName) + "." + random_hex(8);
    const FileDescriptor file = open_file(folder, name, O_WRONLY | O_CREAT | O_EXCL);
    write_all(file, id + "\n", kDataIdName);
    sync(file);
    if (::renameat(folder.get(), name.c_str(), folder.get(), kDataIdName) != 0)
        throw_errno("writing " + (folder_ / kDataIdName).string());
    sync(folder);
}

}  // namespace

std::unique_ptr<BlobStore> open_directory_blob_store(const std::string& folder, Opening opening) {
    return std::make_unique<DirectoryBlobStore>(folder, opening);
}

}  // namespace divemesh::storage
