#pragma once

#include <memory>
#include <span>

#include "api/services.hpp"
#include "api/uploads/upload_checksum.hpp"
#include "api/uploads/upload_writer.hpp"
#include "schemas/upload.hpp"

namespace divemesh::api {

// Stores the bytes of one request beside the upload until their checksum is known. If the server is
// killed meanwhile, the upload contains none of them.
class ChunkWriter : public ByteSink {
public:
    ChunkWriter(Services services, const Upload& upload, UploadChecksum checksum);
    ~ChunkWriter() override;

    std::int64_t room_bytes() const override { return room_bytes_; }
    void write(std::span<const char> bytes) override;
    bool is_right() { return checksum_.matches(); }  // ask it once, at the end
    // Appends a part of the bytes, so that other work in the pool can run; returns false when all
    // of them are appended.
    bool append_some(UploadWriter& writer);

private:
    Services services_;
    std::string key_;
    std::unique_ptr<storage::StagedBlob> staged_;
    UploadChecksum checksum_;
    std::int64_t room_bytes_;
    RoomWatch disk_;
    std::unique_ptr<storage::BlobReader> reader_;  // from the first append_some() on
    std::int64_t appended_ = 0;
};

// Returns the key of the bytes whose checksum is not yet known.
std::string chunk_key(const Upload& upload);

}  // namespace divemesh::api
