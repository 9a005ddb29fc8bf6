#include "storage/s3_blob_store.hpp"

#include <algorithm>
#include <atomic>
#include <ctime>
#include <fcntl.h>
#include <limits>
#include <optional>
#include <utility>

#include "schemas/content_hash.hpp"
#include "schemas/error.hpp"
#include "schemas/log.hpp"
#include "storage/blob_key.hpp"
#include "storage/directory_files.hpp"
#include "storage/file_reader.hpp"
#include "storage/s3_reader.hpp"
#include "storage/s3_transfer.hpp"
#include "storage/upload_stage.hpp"

namespace divemesh::storage {
namespace {

namespace fs = std::filesystem;
constexpr std::size_t kReadBytes = std::size_t{1} << 20;
constexpr std::size_t kMaxDataIdBytes = 128;
constexpr std::time_t kDay_s = 86'400;
constexpr std::time_t kPartsLive_s = 7 * kDay_s;  // longer than any upload takes

[[noreturn]] void throw_missing(const std::string& key) {
    throw Error(ErrorCode::NotFound, "no stored data " + key);
}

std::string sha256_of_file(const fs::path& path) {
    const auto reader =
        read_open_file(FileDescriptor(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW)));
    Sha256 hash;
    std::vector<char> buffer(kReadBytes);
    for (std::int64_t offset = 0;;) {
        const std::size_t n = reader->read_at(offset, buffer);
        if (n == 0) return hash.hex();
        hash.update(std::span(buffer).first(n));
        offset += static_cast<std::int64_t>(n);
    }
}

class S3BlobStore : public BlobStore {
public:
    S3BlobStore(S3Location location,
                S3Credentials credentials,
                const fs::path& stage,
                S3Settings settings)
        : root_(location.prefix),
          client_(std::move(location), std::move(credentials), std::move(settings)) {
        static_cast<void>(data_id());  // says what is wrong with bucket or keys
        if (stage.empty()) return;
        stage_.emplace(make_folder(stage));
        remove_old_parts_daily();
    }

    std::unique_ptr<StagedBlob> open_staged(const std::string& key,
                                            std::int64_t num_durable_bytes) override {
        return stage().open(key, num_durable_bytes);
    }
    std::int64_t staged_size_bytes(const std::string& key) override {
        return stage().size_bytes(key);
    }
    std::unique_ptr<BlobReader> read_staged(const std::string& key) override {
        return stage().read(key);
    }
    void remove_staged(const std::string& key) override { stage().remove(key); }
    void commit_staged(const std::string& staged_key, const std::string& key) override;

    void put_file(const std::string& key, const fs::path& file) override;
    std::unique_ptr<BlobReader> open(const std::string& key) override {
        return read_object(client_, object(key), find(key));
    }
    fs::path local_copy(const std::string& key,
                        const fs::path& copy,
                        const std::string& sha256) override;
    bool exists(const std::string& key) override { return client_.find(object(key)).has_value(); }
    void remove(const std::string& key) override { client_.remove(object(key)); }
    void remove_prefix(const std::string& prefix) override;
    std::vector<std::string> children(const std::string& prefix) override;
    void stop_transfers() override { client_.stop(); }
    std::int64_t free_bytes() override {
        return stage_ ? free_bytes_of(stage_->folder()) : std::numeric_limits<std::int64_t>::max();
    }
    std::string data_id() override;
    void set_data_id(const std::string& id) override;
    std::string location() const override { return client_.location().text(); }

private:
    std::string blobs() const { return root_ + "blobs/"; }
    std::string object(const std::string& key) const {
        split_key(key);
        return blobs() + key;
    }
    std::string data_id_object() const { return root_ + "data-id"; }
    S3Object find(const std::string& key) {
        const auto found = client_.find(object(key));
        if (!found) throw_missing(key);
        return *found;
    }
    const UploadStage& stage() const {
        if (!stage_)
            throw Error(ErrorCode::InvalidArgument,
                        "this process takes no uploads: it has no folder to stage them in");
        return *stage_;
    }
    void remove_old_parts_daily();

    std::string root_;
    S3Client client_;
    std::optional<UploadStage> stage_;
    std::atomic<std::time_t> next_removal_ = 0;
};

// The staged bytes go last, so a program that is killed before that commits them again.
void S3BlobStore::commit_staged(const std::string& staged_key, const std::string& key) {
    const FileDescriptor file = stage().finished(staged_key);
    if (!file.is_open()) {
        if (!exists(key)) throw_missing(staged_key);
        return;
    }
    remove_old_parts_daily();
    send_file(client_, object(key), file);
    stage().remove(staged_key);
}

void S3BlobStore::put_file(const std::string& key, const fs::path& file) {
    const std::string name = object(key);
    const FileDescriptor source(::open(file.c_str(), O_RDONLY | O_NOFOLLOW | O_CLOEXEC));
    if (!source.is_open()) throw_errno("opening " + file.string());
    send_file(client_, name, source);
}

fs::path S3BlobStore::local_copy(const std::string& key,
                                 const fs::path& copy,
                                 const std::string& sha256) {
    const fs::path part = copy.string() + ".part";
    try {
        fetch_file(client_, object(key), find(key), part);
        if (!sha256.empty() && sha256_of_file(part) != sha256)
            throw Error(ErrorCode::Unavailable,
                        key + " in " + location() +
                            " has other bytes than were stored (sha256): restore it from a backup");
        fs::rename(part, copy);
    } catch (...) {
        std::error_code ignored;
        fs::remove(part, ignored);
        throw;
    }
    return copy;
}

void S3BlobStore::remove_prefix(const std::string& prefix) {
    folder_of_prefix(prefix);
    const std::string folder = blobs() + prefix;
    std::vector<std::string> names = client_.list(folder, false).names;
    for (std::string& name : names) name.insert(0, folder);
    constexpr std::size_t kAtATime = S3Client::kMaxKeysAtATime;
    for (std::size_t begin = 0; begin < names.size(); begin += kAtATime) {
        const auto first = names.begin() + static_cast<std::ptrdiff_t>(begin);
        const auto count = std::min(kAtATime, names.size() - begin);
        client_.remove(std::vector<std::string>(first, first + static_cast<std::ptrdiff_t>(count)));
    }
}

std::vector<std::string> S3BlobStore::children(const std::string& prefix) {
    folder_of_prefix(prefix);
    S3Listing listing = client_.list(blobs() + prefix, true);
    std::vector<std::string> names = std::move(listing.names);
    names.insert(names.end(), listing.folders.begin(), listing.folders.end());
    std::sort(names.begin(), names.end());
    return names;
}

std::string S3BlobStore::data_id() {
    const std::string text = client_.get_small(data_id_object(), kMaxDataIdBytes).value_or("");
    return {text.begin(), std::find(text.begin(), text.end(), '\n')};
}

void S3BlobStore::set_data_id(const std::string& id) {
    const std::string text = id + '\n';
    client_.put(data_id_object(), body_of(text));
}

// They cost space alone, so a key without the right to list them does not keep the server from
// starting.
void S3BlobStore::remove_old_parts_daily() {
    const std::time_t now = std::time(nullptr);
    std::time_t due = next_removal_;
    if (now < due || !next_removal_.compare_exchange_strong(due, now + kDay_s)) return;
    try {
        abort_uploads_before(client_, blobs(), now - kPartsLive_s);
    } catch (const Error& error) {
        log_warning({{"event", "s3_old_parts_not_removed"}, {"what", error.what()}});
    }
}

}  // namespace

std::unique_ptr<BlobStore> open_s3_blob_store(S3Location location,
                                              S3Credentials credentials,
                                              const fs::path& stage,
                                              S3Settings settings) {
    return std::make_unique<S3BlobStore>(
        std::move(location), std::move(credentials), stage, std::move(settings));
}

}  // namespace divemesh::storage
