#pragma once

#include <memory>
#include <span>

#include "api/services.hpp"
#include "api/uploads/upload_checksum.hpp"
#include "api/uploads/upload_writer.hpp"
#include "schemas/upload.hpp"

namespace divemesh::api {

// Keeps the bytes of one request beside the upload until their checksum is known: a server that is
// killed meanwhile finds none of them in the upload.
class ChunkWriter : public ByteSink {
public:
    ChunkWriter(Services services, const Upload& upload, UploadChecksum checksum);
    ~ChunkWriter() override;

    std::int64_t room_bytes() const override { return room_bytes_; }
    void write(std::span<const char> bytes) override;
    bool is_right() { return checksum_.matches(); }  // asked once, at the end
    // A stretch at a time, so that others have their turn in the pool; false: all of it is there.
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

// Where the bytes whose checksum is not known yet are.
std::string chunk_key(const Upload& upload);

}  // namespace divemesh::api
