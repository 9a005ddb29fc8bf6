#include "storage/s3_transfer.hpp"

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <exception>
#include <fcntl.h>
#include <mutex>
#include <thread>
#include <unistd.h>
#include <vector>

#include "schemas/error.hpp"
#include "schemas/log.hpp"
#include "storage/directory_files.hpp"
#include "storage/fault_point.hpp"

namespace divemesh::storage {
namespace {

constexpr std::int64_t kMebibyte = std::int64_t{1} << 20;
constexpr std::int64_t kMaxParts = 10'000;
constexpr std::int64_t kMaxObjectBytes = std::int64_t{5} << 40;
constexpr int kNumConnections = 4;

// Calls work(i) for every i below `count` on several threads. After a failure no new one begins;
// the first failure is thrown.
template <typename Work>
void for_each_at_once(std::int64_t count, const Work& work) {
    std::atomic<std::int64_t> next = 0;
    std::mutex mutex;
    std::exception_ptr failure;
    const auto run = [&] {
        for (std::int64_t i = next++; i < count; i = next++) {
            try {
                work(i);
            } catch (...) {
                next = count;
                const std::lock_guard lock(mutex);
                if (!failure) failure = std::current_exception();
            }
        }
    };
    {
        std::vector<std::jthread> others;
        for (std::int64_t i = 1; i < std::min<std::int64_t>(count, kNumConnections); ++i)
            others.emplace_back(run);
        run();
    }
    if (failure) std::rethrow_exception(failure);
}

std::size_t read_range(const FileDescriptor& file, std::int64_t offset, std::span<char> buffer) {
    for (;;) {
        const auto n = pread(file.get(), buffer.data(), buffer.size(), offset);
        if (n >= 0) return static_cast<std::size_t>(n);
        if (errno != EINTR) throw_errno("reading what is sent to the object store");
    }
}

HttpBody range_of(const FileDescriptor& file, std::int64_t begin, std::int64_t size) {
    return {.size_bytes = size,
            .read = [&file, begin](std::int64_t offset, std::span<char> buffer) {
                return read_range(file, begin + offset, buffer);
            }};
}

void write_range(const FileDescriptor& file, std::int64_t offset, std::string_view bytes) {
    while (!bytes.empty()) {
        const auto n = pwrite(file.get(), bytes.data(), bytes.size(), offset);
        if (n < 0 && errno == EINTR) continue;
        if (n < 0) throw_errno("writing a copy of stored data");
        bytes.remove_prefix(static_cast<std::size_t>(n));
        offset += n;
    }
}

// Parts of an object that is not yet one. Removed by the destructor unless it became one.
class PartUpload {
public:
    PartUpload(S3Client& client, const std::string& key)
        : client_(client), key_(key), id_(client.begin_upload(key)) {}
    ~PartUpload() {
        if (is_complete_) return;
        try {
            client_.abort_upload(key_, id_);
        } catch (const std::exception& error) {
            log_warning({{"event", "s3_parts_left"}, {"key", key_}, {"what", error.what()}});
        }
    }
    PartUpload(const PartUpload&) = delete;
    PartUpload& operator=(const PartUpload&) = delete;

    void send(const FileDescriptor& file, std::int64_t size) {
        const std::int64_t part = part_bytes_of(size, client_.part_bytes());
        const std::int64_t count = (size + part - 1) / part;
        std::vector<std::string> etags(static_cast<std::size_t>(count));
        for_each_at_once(count, [&](std::int64_t i) {
            const HttpBody body = range_of(file, i * part, std::min(part, size - i * part));
            etags[static_cast<std::size_t>(i)] =
                client_.put_part(key_, {id_, static_cast<int>(i) + 1}, body);
        });
        fault_point();
        client_.complete_upload(key_, id_, etags, size);
        is_complete_ = true;
    }

private:
    S3Client& client_;
    const std::string& key_;
    std::string id_;
    bool is_complete_ = false;
};

// Returns a time that sorts like the store's own.
std::string iso_time(std::time_t time) {
    std::tm parts{};
    gmtime_r(&time, &parts);
    char text[32];
    const auto size = std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%S", &parts);
    return {text, size};
}

}  // namespace

std::int64_t part_bytes_of(std::int64_t size_bytes, std::int64_t usual_bytes) {
    if (size_bytes > kMaxObjectBytes)
        throw Error(ErrorCode::TooLarge, "an object store takes at most 5 TiB in one object");
    const std::int64_t least = (size_bytes + kMaxParts - 1) / kMaxParts;
    const std::int64_t rounded = (least + kMebibyte - 1) / kMebibyte * kMebibyte;
    return std::max(usual_bytes, rounded);
}

void send_file(S3Client& client, const std::string& key, const FileDescriptor& file) {
    const std::int64_t size = size_of(file);
    if (size > part_bytes_of(size, client.part_bytes())) {
        PartUpload(client, key).send(file, size);
    } else {
        fault_point();
        client.put(key, range_of(file, 0, size));
    }
    fault_point();
}

void fetch_file(S3Client& client,
                const std::string& key,
                const S3Object& object,
                const std::filesystem::path& file) {
    const FileDescriptor copy(
        ::open(file.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_NOFOLLOW | O_CLOEXEC, 0660));
    if (!copy.is_open()) throw_errno("making " + file.string());
    const std::int64_t size = object.size_bytes;
    const std::int64_t range = client.part_bytes();
    for_each_at_once((size + range - 1) / range, [&](std::int64_t i) {
        const std::int64_t offset = i * range;
        const auto length = static_cast<std::size_t>(std::min(range, size - offset));
        write_range(copy, offset, client.get(key, object.etag, offset, length));
    });
}

void abort_uploads_before(S3Client& client, const std::string& prefix, std::time_t time) {
    const std::string limit = iso_time(time);
    for (const S3OpenUpload& upload : client.open_uploads(prefix))
        if (!upload.initiated.empty() && upload.initiated < limit)
            client.abort_upload(upload.key, upload.id);
}

}  // namespace divemesh::storage
