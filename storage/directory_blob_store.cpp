#include "storage/directory_blob_store.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <fcntl.h>
#include <stdio.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <unistd.h>
#include <vector>

#include "schemas/error.hpp"
#include "storage/blob_key.hpp"
#include "storage/directory_files.hpp"
#include "storage/fault_point.hpp"
#include "storage/ids.hpp"

namespace divemesh::storage {
namespace {

namespace fs = std::filesystem;
constexpr std::size_t kCopyBytes = 1 << 20;
constexpr std::int64_t kWriteBackBytes = 8 << 20;
constexpr std::chrono::hours kTemporaryFilesLive{24};
constexpr const char* kDataIdName = "data-id";
constexpr std::size_t kMaxDataIdBytes = 128;

class DirectoryReader : public BlobReader {
public:
    explicit DirectoryReader(FileDescriptor file) : file_(std::move(file)) {}

    std::int64_t size_bytes() const override { return size_of(file_); }
    int descriptor() const override { return file_.get(); }
    std::size_t read_at(std::int64_t offset, std::span<char> buffer) override {
        for (;;) {
            const auto n = pread(file_.get(), buffer.data(), buffer.size(), offset);
            if (n >= 0) return static_cast<std::size_t>(n);
            if (errno != EINTR) throw_errno("reading stored data");
        }
    }

private:
    FileDescriptor file_;
};

class DirectoryStagedBlob : public StagedBlob {
public:
    // Bytes that a killed server wrote may not have reached the disk; this makes them durable.
    DirectoryStagedBlob(FileDescriptor file, std::int64_t num_durable_bytes)
        : file_(std::move(file)), num_durable_bytes_(num_durable_bytes) {
        flush();
        if (lseek(file_.get(), 0, SEEK_END) < 0) throw_errno("opening staged data");
    }

    void write(std::span<const char> bytes) override {
        write_all(file_, bytes, "an upload");
        num_new_bytes_ += static_cast<std::int64_t>(bytes.size());
        if (num_new_bytes_ < kWriteBackBytes) return;
        start_write_back(file_);
        num_new_bytes_ = 0;
    }
    std::int64_t flush() override {
        if (is_broken_)
            throw Error(ErrorCode::Unavailable, "the disk has refused this upload: try again");
        try {
            sync(file_);
        } catch (const Error&) {
            // The kernel has dropped the bytes, and would call the next fsync() a success.
            is_broken_ = true;
            cut_off(num_durable_bytes_);
            is_broken_ = false;
            throw;
        }
        return num_durable_bytes_ = size_bytes();
    }
    std::int64_t size_bytes() const override { return size_of(file_); }

private:
    void cut_off(std::int64_t size) const {
        if (size >= size_bytes()) return;
        if (ftruncate(file_.get(), size) != 0 || lseek(file_.get(), size, SEEK_SET) < 0)
            throw_errno("cutting off what the disk did not take");
    }

    FileDescriptor file_;
    std::int64_t num_durable_bytes_;
    bool is_broken_ = false;          // bytes behind the durable ones could not be cut off
    std::int64_t num_new_bytes_ = 0;  // not yet started to write to the disk
};

class DirectoryBlobStore : public BlobStore {
public:
    DirectoryBlobStore(const std::string& folder, Opening opening)
        : folder_(checked(folder, opening)),
          blobs_(make_area("blobs")),
          staged_(make_area("staged")),
          temporary_(make_area("tmp")) {
        remove_old_temporary_files();
    }

    std::unique_ptr<StagedBlob> open_staged(const std::string& key,
                                            std::int64_t num_durable_bytes) override {
        const auto parts = split_key(key);
        const FileDescriptor parent = open_parent(staged_, parts, true);
        FileDescriptor file = open_file(parent, parts.back(), O_RDWR | O_CREAT);
        sync(parent);
        return std::make_unique<DirectoryStagedBlob>(std::move(file), num_durable_bytes);
    }

    std::int64_t staged_size_bytes(const std::string& key) override {
        const FileDescriptor file = find(staged_, key);
        return file.is_open() ? size_of(file) : 0;
    }

    std::unique_ptr<BlobReader> read_staged(const std::string& key) override {
        return reader(staged_, key);
    }
    void remove_staged(const std::string& key) override { unlink(staged_, key); }
    void commit_staged(const std::string& staged_key, const std::string& key) override;

    void put_file(const std::string& key, const fs::path& file) override;
    std::unique_ptr<BlobReader> open(const std::string& key) override {
        return reader(blobs_, key);
    }
    fs::path local_copy(const std::string& key, const fs::path&) override {
        if (!exists(key)) throw_missing(key);
        return folder_ / "blobs" / key;
    }
    bool exists(const std::string& key) override { return find(blobs_, key).is_open(); }
    void remove(const std::string& key) override { unlink(blobs_, key); }
    void remove_prefix(const std::string& prefix) override;
    std::vector<std::string> children(const std::string& prefix) override;
    std::int64_t free_bytes() override;
    std::string data_id() override;
    void set_data_id(const std::string& id) override;
    std::string location() const override { return fs::absolute(folder_).string(); }

private:
    static fs::path checked(const fs::path& folder, Opening opening);
    FileDescriptor make_area(const std::string& name) const;
    void remove_old_temporary_files() const;
    void publish(const FileDescriptor& from, const std::string& name, const std::string& key);

    static FileDescriptor find(const FileDescriptor& area, const std::string& key) {
        const auto parts = split_key(key);
        return open_file(open_parent(area, parts, false), parts.back(), O_RDONLY);
    }
    static std::unique_ptr<BlobReader> reader(const FileDescriptor& area, const std::string& key) {
        FileDescriptor file = find(area, key);
        if (!file.is_open()) throw_missing(key);
        return std::make_unique<DirectoryReader>(std::move(file));
    }
    static void unlink(const FileDescriptor& area, const std::string& key) {
        const auto parts = split_key(key);
        const FileDescriptor parent = open_parent(area, parts, false);
        if (!parent.is_open()) return;
        if (unlinkat(parent.get(), parts.back().c_str(), 0) != 0 && errno != ENOENT)
            throw_errno("removing stored data");
        sync(parent);
    }
    [[noreturn]] static void throw_missing(const std::string& key) {
        throw Error(ErrorCode::NotFound, "no stored data " + key);
    }

    fs::path folder_;
    FileDescriptor blobs_;
    FileDescriptor staged_;
    FileDescriptor temporary_;
};

FileDescriptor DirectoryBlobStore::make_area(const std::string& name) const {
    std::error_code failure;
    fs::create_directories(folder_ / name, failure);
    if (failure)
        throw Error(ErrorCode::Unavailable,
                    "cannot create " + (folder_ / name).string() + ": " + failure.message());
    sync(open_folder(folder_));
    return open_folder(folder_ / name);
}

// Removes what killed copies left behind.
void DirectoryBlobStore::remove_old_temporary_files() const {
    std::error_code ignored;
    const auto limit = fs::file_time_type::clock::now() - kTemporaryFilesLive;
    for (const auto& entry : fs::directory_iterator(folder_ / "tmp", ignored))
        if (entry.last_write_time(ignored) < limit) fs::remove(entry.path(), ignored);
}

void DirectoryBlobStore::commit_staged(const std::string& staged_key, const std::string& key) {
    const auto parts = split_key(staged_key);
    const FileDescriptor parent = open_parent(staged_, parts, false);
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

std::string folder_of(const std::string& prefix) {
    if (!prefix.ends_with('/'))
        throw Error(ErrorCode::InvalidArgument, "a prefix of blobs ends with a slash: " + prefix);
    return prefix.substr(0, prefix.size() - 1);
}

std::vector<std::string> DirectoryBlobStore::children(const std::string& prefix) {
    const std::string folder = folder_of(prefix);
    split_key(folder);
    std::vector<std::string> names;
    std::error_code missing;
    for (const auto& entry : fs::directory_iterator(folder_ / "blobs" / folder, missing))
        names.push_back(entry.path().filename().string());
    std::sort(names.begin(), names.end());
    return names;
}

void DirectoryBlobStore::remove_prefix(const std::string& prefix) {
    const std::string folder = folder_of(prefix);
    const auto parts = split_key(folder);
    const FileDescriptor parent = open_parent(blobs_, parts, false);
    if (!parent.is_open()) return;
    std::error_code failure;
    fs::remove_all(folder_ / "blobs" / folder, failure);  // follows no symbolic link
    if (failure)
        throw Error(ErrorCode::Unavailable, "removing " + prefix + ": " + failure.message());
    sync(parent);
}

std::int64_t DirectoryBlobStore::free_bytes() {
    struct statvfs status {};
    if (fstatvfs(blobs_.get(), &status) != 0) throw_errno("asking for free space");
    return static_cast<std::int64_t>(status.f_bavail) * static_cast<std::int64_t>(status.f_frsize);
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
