#include "api/upload_writer.hpp"

#include "schemas/error.hpp"
#include "storage/upload_store.hpp"

namespace divemesh::api {
namespace {

constexpr std::int64_t kFlushEveryBytes = std::int64_t{64} << 20;

}  // namespace

UploadWriter::UploadWriter(Services services, Upload upload)
    : services_(services), upload_(std::move(upload)) {
    staged_ = services_.blobs.open_staged(upload_.blob);
    if (staged_->size_bytes() < upload_.offset_bytes)
        throw std::runtime_error("upload " + upload_.id + " has lost bytes: the catalog knows " +
                                 std::to_string(upload_.offset_bytes) + ", the disk has " +
                                 std::to_string(staged_->size_bytes()));
    advance();
    written_ = upload_.offset_bytes;
    hash_ = services_.hashes.take(upload_.id, written_);
}

void UploadWriter::write(std::span<const char> bytes) {
    staged_->write(bytes);
    written_ += static_cast<std::int64_t>(bytes.size());
    if (hash_) hash_->update(bytes);
    if (written_ - upload_.offset_bytes >= kFlushEveryBytes) advance();
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
}

Upload reconciled(const Services& services, const Upload& upload) {
    if (upload.complete() || services.blobs.staged_size_bytes(upload.blob) <= upload.offset_bytes)
        return upload;
    return UploadWriter(services, upload).upload();
}

}  // namespace divemesh::api
