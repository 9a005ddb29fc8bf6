#include "api/uploads/chunk_writer.hpp"

#include <nlohmann/json.hpp>
#include <vector>

#include "schemas/log.hpp"

namespace divemesh::api {
namespace {

constexpr std::size_t kCopyBytes = std::size_t{1} << 20;
constexpr int kCopiesAtATime = 32;

}  // namespace

std::string chunk_key(const Upload& upload) { return upload.blob + ".chunk"; }

ChunkWriter::ChunkWriter(Services services, const Upload& upload, UploadChecksum checksum)
    : services_(services),
      key_(chunk_key(upload)),
      checksum_(std::move(checksum)),
      room_bytes_(upload.length_bytes.value_or(services.limits.max_upload_bytes) -
                  upload.offset_bytes) {
    services_.blobs.remove_staged(key_);  // left by a killed server
    staged_ = services_.blobs.open_staged(key_);
}

ChunkWriter::~ChunkWriter() {
    try {
        services_.blobs.remove_staged(key_);
    } catch (const std::exception& error) {
        log_warning({{"event", "chunk_left"}, {"blob", key_}, {"what", error.what()}});
    }
}

void ChunkWriter::write(std::span<const char> bytes) {
    staged_->write(bytes);
    checksum_.update(bytes);
    room_bytes_ -= static_cast<std::int64_t>(bytes.size());
    disk_.wrote(services_, bytes.size());
}

bool ChunkWriter::append_some(UploadWriter& writer) {
    if (!reader_) {
        staged_->flush();
        reader_ = services_.blobs.read_staged(key_);
    }
    std::vector<char> buffer(kCopyBytes);
    for (int i = 0; i < kCopiesAtATime; ++i) {
        const std::size_t n = reader_->read_at(appended_, buffer);
        if (n == 0) return false;
        writer.write({buffer.data(), n});
        appended_ += static_cast<std::int64_t>(n);
    }
    return true;
}

}  // namespace divemesh::api
