#include "storage/s3_reader.hpp"

#include <algorithm>
#include <utility>

namespace divemesh::storage {
namespace {

constexpr std::size_t kFirstBytes = std::size_t{256} << 10;
constexpr std::size_t kMaxBytes = std::size_t{2} << 20;  // every download under way holds as much

class S3Reader : public BlobReader {
public:
    S3Reader(S3Client& client, std::string key, S3Object object)
        : client_(client), key_(std::move(key)), object_(std::move(object)) {}

    std::int64_t size_bytes() const override { return object_.size_bytes; }

    std::size_t read_at(std::int64_t offset, std::span<char> buffer) override {
        if (offset >= object_.size_bytes) return 0;
        const auto left = static_cast<std::size_t>(object_.size_bytes - offset);
        const auto wanted = buffer.first(std::min(buffer.size(), left));
        std::size_t num_read = 0;
        while (num_read < wanted.size())
            num_read +=
                copy(offset + static_cast<std::int64_t>(num_read), wanted.subspan(num_read));
        return num_read;
    }

private:
    std::int64_t end() const { return begin_ + static_cast<std::int64_t>(bytes_.size()); }

    // Returns how many bytes it copied: at least one.
    std::size_t copy(std::int64_t offset, std::span<char> buffer) {
        if (offset < begin_ || offset >= end()) fetch(offset, buffer.size());
        return bytes_.copy(buffer.data(), buffer.size(), static_cast<std::size_t>(offset - begin_));
    }

    void fetch(std::int64_t offset, std::size_t wanted) {
        const bool reads_on = offset == end();
        ahead_ = reads_on ? std::min(2 * ahead_, kMaxBytes) : kFirstBytes;
        const auto left = static_cast<std::size_t>(object_.size_bytes - offset);
        bytes_ = client_.get(
            key_, object_.etag, offset, std::min(std::clamp(wanted, ahead_, kMaxBytes), left));
        begin_ = offset;
    }

    S3Client& client_;
    std::string key_;
    S3Object object_;
    std::int64_t begin_ = 0;  // of the bytes that are here
    std::string bytes_;
    std::size_t ahead_ = kFirstBytes / 2;
};

}  // namespace

std::unique_ptr<BlobReader> read_object(S3Client& client, const std::string& key, S3Object object) {
    return std::make_unique<S3Reader>(client, key, std::move(object));
}

}  // namespace divemesh::storage
