#include "api/uploads/concatenation.hpp"

#include <algorithm>
#include <set>
#include <vector>

#include "api/in_pool.hpp"
#include "api/uploads/new_upload.hpp"
#include "api/uploads/tus_headers.hpp"
#include "api/uploads/upload_writer.hpp"
#include "schemas/error.hpp"
#include "storage/upload_store.hpp"

namespace divemesh::api {
namespace {

constexpr std::size_t kCopyBytes = std::size_t{1} << 20;
constexpr int kCopiesAtATime = 32;  // in the pool, before other work may run

Upload read_part(const Services& services, const Upload& whole, const std::string& id) {
    Upload part = storage::UploadStore(services.catalog).get(id);
    if (part.project != whole.project) throw Error(ErrorCode::NotFound, "no upload " + id);
    storage::require_open(part);
    if (!part.is_partial())
        throw Error(ErrorCode::InvalidArgument,
                    "upload " + id + " is not a part: create it with Upload-Concat: partial");
    if (!part.complete())
        throw Error(ErrorCode::Conflict, "upload " + id + " is not complete: send the rest first");
    return part;
}

// Copies the parts of an upload into it, some at a time.
class Concatenation {
public:
    Concatenation(const Services& services, const Upload& whole)
        : services_(services), writer_(services, whole), buffer_(kCopyBytes) {
        std::int64_t start = 0;
        for (const std::string& id : parts_of(whole)) {
            parts_.push_back({read_part(services, whole, id), start});
            start += *parts_.back().upload.length_bytes;
        }
        offset_ = writer_.upload().offset_bytes;
    }

    // Returns false when all of it is copied.
    bool copy_some() {
        for (int i = 0; i < kCopiesAtATime && writer_.room_bytes() > 0; ++i) copy_once();
        return writer_.room_bytes() > 0;
    }
    const Upload& finish() { return writer_.finish(); }

private:
    struct Part {
        Upload upload;
        std::int64_t start;
    };

    void copy_once() {
        const auto after = std::upper_bound(
            parts_.begin(), parts_.end(), offset_, [](std::int64_t at, const Part& part) {
                return at < part.start;
            });
        const Part& part = *(after - 1);
        const std::int64_t in_part = offset_ - part.start;
        if (open_ != &part) reader_ = services_.blobs.read_staged(part.upload.blob);
        open_ = &part;
        const auto wanted = static_cast<std::size_t>(
            std::min<std::int64_t>(kCopyBytes, *part.upload.length_bytes - in_part));
        const std::size_t n = reader_->read_at(in_part, std::span(buffer_).first(wanted));
        if (n == 0)
            throw std::runtime_error("upload " + part.upload.id + " is shorter than it was");
        writer_.write({buffer_.data(), n});
        offset_ += static_cast<std::int64_t>(n);
    }

    Services services_;
    UploadWriter writer_;
    std::vector<char> buffer_;
    std::vector<Part> parts_;
    std::int64_t offset_ = 0;
    const Part* open_ = nullptr;
    std::unique_ptr<storage::BlobReader> reader_;
};

}  // namespace

Upload enter_final(const Services& services, storage::Catalog& catalog, Upload wanted) {
    if (auto known = storage::UploadStore(services.catalog).find_final(wanted))
        return std::move(*known);
    const std::vector<std::string> part_ids = parts_of(wanted);
    const std::int64_t max_bytes = services.limits.max_upload_bytes;
    std::int64_t length = 0;
    for (const std::string& id : part_ids) {
        length += *read_part(services, wanted, id).length_bytes;
        if (length > max_bytes)
            throw Error(
                ErrorCode::TooLarge,
                "the parts together have more than " + std::to_string(max_bytes) + " bytes");
    }
    wanted.length_bytes = length;
    return enter_upload(services, catalog, wanted, part_ids);
}

Awaitable<Upload> concatenate(Services services,
                              Upload upload,
                              std::shared_ptr<std::atomic<bool>> stop) {
    auto begin = [services, upload] { return std::make_shared<Concatenation>(services, upload); };
    auto concatenation = co_await in_pool(services.pool, std::move(begin));
    for (bool more = true; more;) {
        if (*stop || services.stopping)
            throw Error(ErrorCode::Conflict,
                        "a newer request took over this upload, or the server is stopping");
        auto copy = [concatenation] { return concatenation->copy_some(); };
        more = co_await in_pool(services.pool, std::move(copy));
    }
    auto finish = [services, concatenation] {
        Upload whole = concatenation->finish();
        free_parts(services, whole);
        return whole;
    };
    co_return co_await in_pool(services.pool, std::move(finish));
}

void free_parts(const Services& services, const Upload& whole) {
    storage::UploadStore uploads(services.catalog);
    const std::vector<std::string> ids = parts_of(whole);
    for (const std::string& id : std::set<std::string>(ids.begin(), ids.end())) {
        const auto part = uploads.find(id);
        if (!part || part->end) continue;
        try {
            uploads.end(id, UploadEnd::Concatenated);
            free_bytes(services, *part);
        } catch (const Error& error) {
            if (error.code() != ErrorCode::Locked) throw;
        }
    }
}

}  // namespace divemesh::api
