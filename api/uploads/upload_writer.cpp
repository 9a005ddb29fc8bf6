#include "api/uploads/upload_writer.hpp"

#include "api/quota.hpp"
#include "api/uploads/chunk_writer.hpp"
#include "api/uploads/make_dive.hpp"
#include "schemas/error.hpp"
#include "storage/upload_store.hpp"

namespace divemesh::api {
namespace {

// How much a power cut may lose: bytes that no response has confirmed.
constexpr std::int64_t kFlushEveryBytes = std::int64_t{256} << 20;
constexpr std::chrono::seconds kFlushEvery{5};

}  // namespace

UploadWriter::UploadWriter(Services services, Upload upload)
    : services_(services), upload_(std::move(upload)) {
    staged_ = services_.blobs.open_staged(upload_.blob, upload_.offset_bytes);
    if (staged_->size_bytes() < upload_.offset_bytes)
        throw std::runtime_error("upload " + upload_.id +
                                 " has lost bytes: the catalog has recorded " +
                                 std::to_string(upload_.offset_bytes) + ", the disk has " +
                                 std::to_string(staged_->size_bytes()));
    advance();
    written_ = upload_.offset_bytes;
    hash_ = services_.hashes.take(upload_.id, written_);
}

std::int64_t UploadWriter::room_bytes() const {
    return upload_.length_bytes.value_or(services_.limits.max_upload_bytes) - written_;
}

void UploadWriter::write(std::span<const char> bytes) {
    staged_->write(bytes);
    written_ += static_cast<std::int64_t>(bytes.size());
    if (hash_) hash_->update(bytes);
    room_.wrote(services_, bytes.size());
    const bool is_time = std::chrono::steady_clock::now() - flushed_ >= kFlushEvery;
    if (!is_time && written_ - upload_.offset_bytes < kFlushEveryBytes) return;
    advance();
    if (!upload_.length_bytes) require_bytes_of_quota(services_, upload_.project, 0);
}

const Upload& UploadWriter::finish() {
    advance();
    if (hash_ && written_ == upload_.offset_bytes)
        services_.hashes.put(upload_.id, written_, std::move(*hash_));
    hash_.reset();
    return upload_;
}

void UploadWriter::advance() {
    const std::int64_t durable = staged_->flush();
    if (durable > upload_.offset_bytes)
        upload_ = storage::UploadStore(services_.catalog).advance(upload_.id, durable);
    flushed_ = std::chrono::steady_clock::now();
}

Upload reconciled(const Services& services, const Upload& upload) {
    if (upload.complete() || services.blobs.staged_size_bytes(upload.blob) <= upload.offset_bytes)
        return upload;
    return UploadWriter(services, upload).upload();
}

void free_bytes(const Services& services, const Upload& upload) {
    services.blobs.remove_staged(upload.blob);
    services.blobs.remove_staged(chunk_key(upload));
    services.hashes.forget(upload.id);
    // If the server was killed before the catalog knew, the bytes are under the key of the dive's
    // blob.
    if (upload.dive_id.empty()) services.blobs.remove(archive_key(upload));
    storage::UploadStore(services.catalog).set_freed(upload.id);
}

}  // namespace divemesh::api
