#include "sensor/ring/segment_file.hpp"

#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <optional>
#include <sys/stat.h>
#include <system_error>

#include "schemas/crc32c.hpp"
#include "schemas/error.hpp"

namespace divemesh::sensor {
namespace {

constexpr std::string_view kMagic = "dmring1\n";

[[noreturn]] void fail(const std::filesystem::path& path, const char* verb, int code) {
    const bool is_full = code == ENOSPC || code == EDQUOT || code == EFBIG;
    std::string what = "cannot ";
    what.append(verb).append(" ").append(path.string()).append(": ");
    throw Error(is_full ? ErrorCode::OutOfSpace : ErrorCode::Unavailable,
                what.append(std::generic_category().message(code)));
}

// Reads up to `num_bytes`, as many as there are.
std::string read_at(int descriptor, std::int64_t offset, std::size_t num_bytes) {
    std::string bytes(num_bytes, '\0');
    std::size_t done = 0;
    while (done < num_bytes) {
        const ssize_t got = ::pread(descriptor,
                                    bytes.data() + done,
                                    num_bytes - done,
                                    offset + static_cast<std::int64_t>(done));
        if (got < 0 && errno == EINTR) continue;
        if (got <= 0) break;
        done += static_cast<std::size_t>(got);
    }
    bytes.resize(done);
    return bytes;
}

struct Head {
    std::uint32_t num_bytes = 0;
    std::uint32_t checksum = 0;  // of the length and the payload
};

std::uint32_t checksum_of(std::uint32_t num_bytes, std::string_view payload) {
    std::string all(sizeof num_bytes, '\0');
    std::memcpy(all.data(), &num_bytes, sizeof num_bytes);
    return crc32c(all.append(payload));
}

// Returns nullopt if the record is torn or changed.
std::optional<std::string> record_at(int descriptor, std::int64_t offset) {
    const std::string bytes = read_at(descriptor, offset, sizeof(Head));
    if (bytes.size() < sizeof(Head)) return std::nullopt;
    Head head;
    std::memcpy(&head, bytes.data(), sizeof head);
    if (head.num_bytes > SegmentFile::kMaxRecordBytes) return std::nullopt;
    std::string payload = read_at(descriptor, offset + SegmentFile::kHeadBytes, head.num_bytes);
    if (payload.size() < head.num_bytes || checksum_of(head.num_bytes, payload) != head.checksum)
        return std::nullopt;
    return payload;
}

struct FoundRecord {
    std::int64_t offset = 0;
    std::string payload;
};

// Returns the first complete record from `offset` on.
std::optional<FoundRecord> find_record(int descriptor, std::int64_t offset) {
    constexpr std::size_t kWindowBytes = std::size_t{64} << 10;
    const std::int64_t end = offset + SegmentFile::kMaxSearchBytes;
    for (; offset < end; offset += static_cast<std::int64_t>(kWindowBytes)) {
        const std::string window = read_at(descriptor, offset, kWindowBytes + sizeof(Head));
        for (std::size_t i = 0; i < kWindowBytes && i + sizeof(Head) < window.size(); ++i) {
            Head head;
            std::memcpy(&head, window.data() + i, sizeof head);
            if (head.num_bytes == 0 || head.num_bytes > SegmentFile::kMaxRecordBytes) continue;
            const std::int64_t at = offset + static_cast<std::int64_t>(i);
            if (auto payload = record_at(descriptor, at)) return {{at, std::move(*payload)}};
        }
        if (window.size() < kWindowBytes) break;
    }
    return std::nullopt;
}

}  // namespace

SegmentFile SegmentFile::create(const std::filesystem::path& path) {
    FileDescriptor created(::open(path.c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0600));
    if (!created.is_open()) fail(path, "create", errno);
    SegmentFile file(path, std::move(created));
    try {
        file.write_at(0, kMagic);
    } catch (const Error&) {
        ::unlink(path.c_str());
        throw;
    }
    file.size_bytes_ = static_cast<std::int64_t>(kMagic.size());
    return file;
}

SegmentFile SegmentFile::open(const std::filesystem::path& path, const OnRecord& on_record) {
    FileDescriptor opened(::open(path.c_str(), O_RDWR | O_CLOEXEC | O_NOFOLLOW));
    if (!opened.is_open())
        opened = FileDescriptor(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW));
    if (!opened.is_open()) fail(path, "open", errno);
    SegmentFile file(path, std::move(opened));
    const int descriptor = file.descriptor_.get();
    file.size_bytes_ = static_cast<std::int64_t>(kMagic.size());
    file.is_damaged_ = read_at(descriptor, 0, kMagic.size()) != kMagic;
    while (const auto record = find_record(descriptor, file.size_bytes_)) {
        file.is_damaged_ = file.is_damaged_ || record->offset != file.size_bytes_;
        on_record(record->offset, record->payload);
        file.size_bytes_ =
            record->offset + kHeadBytes + static_cast<std::int64_t>(record->payload.size());
    }
    if (file.is_damaged_ && file.size_bytes_ == static_cast<std::int64_t>(kMagic.size()))
        throw Error(ErrorCode::BadData, path.string() + " is not a segment of a ring");
    // On a read-only disk the torn tail stays; the next start cuts it off.
    if (::ftruncate(descriptor, file.size_bytes_) != 0) return file;
    return file;
}

std::int64_t SegmentFile::append(std::string_view payload) {
    if (payload.size() > kMaxRecordBytes)
        throw Error(ErrorCode::TooLarge, "a record of the ring is too long");
    const auto num_bytes = static_cast<std::uint32_t>(payload.size());
    const Head head{num_bytes, checksum_of(num_bytes, payload)};
    std::string bytes(sizeof head, '\0');
    std::memcpy(bytes.data(), &head, sizeof head);
    const std::int64_t offset = size_bytes_;
    write_at(offset, bytes.append(payload));
    size_bytes_ += static_cast<std::int64_t>(bytes.size());
    return offset;
}

void SegmentFile::write_at(std::int64_t offset, std::string_view bytes) const {
    const std::int64_t begin = offset;
    while (!bytes.empty()) {
        const ssize_t written = ::pwrite(descriptor_.get(), bytes.data(), bytes.size(), offset);
        if (written < 0 && errno == EINTR) continue;
        if (written <= 0) {
            const int code = written < 0 ? errno : ENOSPC;
            // If this fails too, the bytes are a torn record and are ignored.
            if (::ftruncate(descriptor_.get(), begin) != 0) fail(path_, "write", code);
            fail(path_, "write", code);
        }
        bytes.remove_prefix(static_cast<std::size_t>(written));
        offset += written;
    }
}

std::string SegmentFile::read(std::int64_t offset) const {
    auto payload = record_at(descriptor_.get(), offset);
    if (!payload) throw Error(ErrorCode::BadData, path_.string() + " is damaged");
    return std::move(*payload);
}

void SegmentFile::sync() const {
    if (::fdatasync(descriptor_.get()) != 0) fail(path_, "sync", errno);
}

bool SegmentFile::is_removed() const {
    struct stat status {};
    return ::fstat(descriptor_.get(), &status) != 0 || status.st_nlink == 0;
}

}  // namespace divemesh::sensor
