#include "storage/backup.hpp"

#include <archive.h>
#include <archive_entry.h>
#include <cstdio>
#include <fcntl.h>
#include <map>
#include <memory>
#include <set>
#include <unistd.h>
#include <vector>

#include "schemas/content_hash.hpp"
#include "schemas/error.hpp"
#include "storage/data_id.hpp"
#include "storage/directory_files.hpp"
#include "storage/ids.hpp"
#include "storage/sql.hpp"

namespace divemesh::storage {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kChunkBytes = std::size_t{1} << 20;
constexpr const char* kCatalogName = "catalog.db";
constexpr const char* kEndName = "end-of-backup";  // holds the number of blobs, detects a cut
constexpr std::string_view kBlobsFolder = "blobs/";

using Archive = std::unique_ptr<archive, int (*)(archive*)>;

// A temporary file beside the final one; removed unless it is renamed to the final one.
class Part {
public:
    explicit Part(fs::path file) : file_(std::move(file)) { fs::remove(file_); }
    ~Part() {
        std::error_code ignored;
        for (const char* suffix : {"", "-wal", "-shm"})
            fs::remove(file_.string() + suffix, ignored);
    }
    Part(const Part&) = delete;
    Part& operator=(const Part&) = delete;

    const fs::path& path() const { return file_; }
    void become(const fs::path& whole) {
        const FileDescriptor part(::open(file_.c_str(), O_RDONLY | O_CLOEXEC));
        sync(part);
        if (::rename(file_.c_str(), whole.c_str()) != 0) throw_errno("making " + whole.string());
        sync(open_folder(fs::absolute(whole).parent_path().string()));
    }

private:
    fs::path file_;
};

// Creates a private file, because the catalog holds the secrets of webhooks and the hashes of
// tokens.
FileDescriptor make_private(const fs::path& file) {
    FileDescriptor made(::open(file.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0600));
    if (!made.is_open()) throw_errno("making " + file.string());
    return made;
}

// Returns the blobs that the catalog names: key -> sha256, "" where it knows no hash.
std::map<std::string, std::string> named_blobs(Catalog& catalog) {
    struct Row {
        std::string blob;
        std::string sha256;
        void define(soci::statement& statement) { define_columns(statement, blob, sha256); }
        std::pair<std::string, std::string> value() const { return {blob, sha256}; }
    };
    std::map<std::string, std::string> blobs;
    catalog.read([&](soci::session& session) {
        for (auto& [blob, sha256] :
             select_all<Row>(session,
                             "SELECT blob, archive_sha256 FROM dives"
                             " UNION ALL SELECT blob, sha256 FROM artifacts"
                             " UNION ALL SELECT blob, sha256 FROM truth_files"
                             " WHERE deleted_at_ms = 0"
                             " UNION ALL SELECT thumbnail_blob, '' FROM dives"
                             " WHERE thumbnail_blob <> ''"))
            blobs.emplace(std::move(blob), std::move(sha256));
    });
    return blobs;
}

void forget_unfinished_uploads(Catalog& catalog) {
    catalog.transaction([](soci::session& session) {
        execute(session, "DELETE FROM uploads WHERE dive_id IS NULL");
    });
}

// Returns the code for a failure of libarchive: `unsound` if it is the content that is at fault.
ErrorCode code_of(archive* tar, ErrorCode unsound) {
    switch (archive_errno(tar)) {
        case ENOSPC:
        case EDQUOT: return ErrorCode::OutOfSpace;
        case ENOENT: return ErrorCode::NotFound;
        case EIO:
        case EACCES:
        case EMFILE:
        case ENFILE:
        case ENOMEM: return ErrorCode::Unavailable;
        default: return unsound;
    }
}

void check(int result, archive* tar, ErrorCode unsound, const std::string& doing) {
    if (result == ARCHIVE_OK || result == ARCHIVE_WARN) return;
    const char* why = archive_error_string(tar);
    throw Error(code_of(tar, unsound), doing + ": " + (why ? why : "it fails"));
}

class TarWriter {
public:
    explicit TarWriter(const fs::path& file)
        : file_(make_private(file)), tar_(archive_write_new(), archive_write_free) {
        archive_write_set_format_pax_restricted(tar_.get());
        check(archive_write_open_fd(tar_.get(), file_.get()),
              tar_.get(),
              ErrorCode::Unavailable,
              "writing " + file.string());
    }

    void add(const std::string& name, BlobReader& reader) {
        const std::int64_t size = reader.size_bytes();
        const std::unique_ptr<archive_entry, void (*)(archive_entry*)> entry(archive_entry_new(),
                                                                             archive_entry_free);
        archive_entry_set_pathname(entry.get(), name.c_str());
        archive_entry_set_size(entry.get(), size);
        archive_entry_set_filetype(entry.get(), AE_IFREG);
        archive_entry_set_perm(entry.get(), 0640);
        write(archive_write_header(tar_.get(), entry.get()), name);
        for (std::int64_t offset = 0; offset < size;) {
            const std::size_t n = reader.read_at(offset, buffer_);
            if (n == 0)
                throw Error(ErrorCode::Unavailable, name + " became shorter while it was read");
            const auto written = archive_write_data(tar_.get(), buffer_.data(), n);
            if (written < 0) write(static_cast<int>(written), name);
            offset += static_cast<std::int64_t>(n);
        }
    }
    void finish() { write(archive_write_close(tar_.get()), "the end"); }

private:
    void write(int result, const std::string& what) {
        check(result, tar_.get(), ErrorCode::Unavailable, "writing " + what + " to the backup");
    }

    FileDescriptor file_;
    Archive tar_;
    std::vector<char> buffer_ = std::vector<char>(kChunkBytes);
};

class FileReader : public BlobReader {
public:
    explicit FileReader(const fs::path& file) : file_(::open(file.c_str(), O_RDONLY | O_CLOEXEC)) {
        if (!file_.is_open()) throw_errno("opening " + file.string());
    }
    std::int64_t size_bytes() const override { return size_of(file_); }
    std::size_t read_at(std::int64_t offset, std::span<char> buffer) override {
        const auto n = pread(file_.get(), buffer.data(), buffer.size(), offset);
        if (n < 0) throw_errno("reading the catalog's copy");
        return static_cast<std::size_t>(n);
    }

private:
    FileDescriptor file_;
};

class TextReader : public BlobReader {
public:
    explicit TextReader(std::string text) : text_(std::move(text)) {}
    std::int64_t size_bytes() const override { return static_cast<std::int64_t>(text_.size()); }
    std::size_t read_at(std::int64_t offset, std::span<char> buffer) override {
        return text_.copy(buffer.data(), buffer.size(), static_cast<std::size_t>(offset));
    }

private:
    std::string text_;
};

class TarReader {
public:
    explicit TarReader(const fs::path& file) : tar_(archive_read_new(), archive_read_free) {
        archive_read_support_format_tar(tar_.get());
        read(archive_read_open_filename(tar_.get(), file.c_str(), kChunkBytes));
    }

    // Returns the next entry's name; "" at the end.
    std::string next() {
        archive_entry* entry = nullptr;
        const int result = archive_read_next_header(tar_.get(), &entry);
        if (result == ARCHIVE_EOF) return "";
        read(result);
        if (archive_entry_filetype(entry) != AE_IFREG || archive_entry_pathname(entry) == nullptr)
            throw Error(ErrorCode::BadData,
                        "this is not a backup: it contains other entries than files");
        return archive_entry_pathname(entry);
    }

    template <typename Sink>
    void copy(const Sink& sink) {
        for (;;) {
            const auto n = archive_read_data(tar_.get(), buffer_.data(), buffer_.size());
            if (n < 0) read(static_cast<int>(n));
            if (n <= 0) return;
            sink(std::span<const char>(buffer_.data(), static_cast<std::size_t>(n)));
        }
    }

private:
    void read(int result) { check(result, tar_.get(), ErrorCode::BadData, "reading the backup"); }

    Archive tar_;
    std::vector<char> buffer_ = std::vector<char>(kChunkBytes);
};

std::int64_t restore_blob(TarReader& tar,
                          const std::string& key,
                          const std::string& sha256,
                          BlobStore& blobs) {
    const std::string staged_key = "restore/" + random_hex(8);
    std::int64_t num_bytes = 0;
    Sha256 hash;
    {
        const auto staged = blobs.open_staged(staged_key);
        tar.copy([&](std::span<const char> bytes) {
            staged->write(bytes);
            hash.update(bytes);
            num_bytes += static_cast<std::int64_t>(bytes.size());
        });
        staged->flush();
    }
    if (!sha256.empty() && hash.hex() != sha256) {
        blobs.remove_staged(staged_key);
        throw Error(ErrorCode::BadData, "the backup is damaged: " + key + " has changed");
    }
    blobs.commit_staged(staged_key, key);
    return num_bytes;
}

void restore_catalog(TarReader& tar, const fs::path& file) {
    if (tar.next() != kCatalogName)
        throw Error(ErrorCode::BadData, "this is not a backup of divemesh: it has no catalog");
    const FileDescriptor catalog(
        ::open(file.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0660));
    if (!catalog.is_open()) throw_errno("making " + file.string());
    tar.copy([&](std::span<const char> bytes) { write_all(catalog, bytes, file.string()); });
    sync(catalog);
}

void check_end(TarReader& tar, const std::string& name, std::int64_t num_blobs) {
    std::string count;
    if (name == kEndName)
        tar.copy([&](std::span<const char> bytes) { count.append(bytes.begin(), bytes.end()); });
    if (count != std::to_string(num_blobs))
        throw Error(ErrorCode::BadData, "the backup is damaged: its end is missing");
}

// Returns null if the blob is gone, or is just being removed.
std::unique_ptr<BlobReader> open_if_there(BlobStore& blobs, const std::string& key) {
    try {
        return blobs.open(key);
    } catch (const Error& error) {
        if (error.code() == ErrorCode::NotFound) return nullptr;
        throw;
    }
}

}  // namespace

BackupSummary write_backup(Catalog& catalog, BlobStore& blobs, const fs::path& file) {
    const Part snapshot(file.string() + ".catalog");
    make_private(snapshot.path());
    catalog.copy_to(snapshot.path().string());
    std::map<std::string, std::string> named;
    {
        Catalog copy("sqlite://" + fs::absolute(snapshot.path()).string());
        forget_unfinished_uploads(copy);
        named = named_blobs(copy);
        copy.checkpoint();
    }
    Part part(file.string() + ".part");
    TarWriter tar(part.path());
    FileReader reader(snapshot.path());
    tar.add(kCatalogName, reader);
    BackupSummary summary;
    for (const auto& [key, sha256] : named) {
        const auto blob = open_if_there(blobs, key);
        if (!blob) {
            ++summary.num_missing;
            continue;
        }
        tar.add(std::string(kBlobsFolder) + key, *blob);
        ++summary.num_blobs;
        summary.num_bytes += blob->size_bytes();
    }
    TextReader end(std::to_string(summary.num_blobs));
    tar.add(kEndName, end);
    tar.finish();
    part.become(file);
    return summary;
}

BackupSummary read_backup(const fs::path& file, const fs::path& catalog_file, BlobStore& blobs) {
    if (fs::exists(catalog_file))
        throw Error(ErrorCode::Conflict,
                    catalog_file.string() + " already exists: restore into an empty folder");
    TarReader tar(file);
    Part part(catalog_file.string() + ".part");
    restore_catalog(tar, part.path());
    std::map<std::string, std::string> named;
    {
        Catalog catalog("sqlite://" + fs::absolute(part.path()).string());
        named = named_blobs(catalog);
    }
    BackupSummary summary;
    std::string name = tar.next();
    for (; name.starts_with(kBlobsFolder); name = tar.next()) {
        const std::string key = name.substr(kBlobsFolder.size());
        const auto known = named.find(key);
        if (known == named.end())
            throw Error(ErrorCode::BadData,
                        "the backup contains a blob that its catalog does not list");
        summary.num_bytes += restore_blob(tar, key, known->second, blobs);
        ++summary.num_blobs;
        named.erase(known);
    }
    check_end(tar, name, summary.num_blobs);
    summary.num_missing = static_cast<std::int64_t>(named.size());
    {
        Catalog catalog("sqlite://" + fs::absolute(part.path()).string());
        adopt_blobs(catalog, blobs);
        catalog.checkpoint();
    }
    part.become(catalog_file);
    return summary;
}

}  // namespace divemesh::storage
