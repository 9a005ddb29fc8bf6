#pragma once

#include <memory>
#include <optional>
#include <span>

#include "api/services.hpp"
#include "schemas/content_hash.hpp"
#include "schemas/upload.hpp"

namespace divemesh::api {

// Appends to the staged bytes of one upload. Every method blocks: for the pool. What finish() has
// returned is on disk and in the catalog; offsets never go down.
class UploadWriter {
public:
    // Goes on where the durable bytes end: a server that was killed may have left more of them
    // than the catalog knew. `upload` must be fresh and the caller has its turn.
    UploadWriter(Services services, Upload upload);

    const Upload& upload() const { return upload_; }
    std::int64_t room_bytes() const { return upload_.length_bytes - written_; }

    // At most room_bytes(). Makes durable what has come every now and then. Throws
    // Error{OutOfSpace}; what fitted is kept.
    void write(std::span<const char> bytes);
    const Upload& finish();

private:
    void advance();

    Services services_;
    Upload upload_;
    std::unique_ptr<storage::StagedBlob> staged_;
    std::optional<Sha256> hash_;  // of everything so far, when that is known
    std::int64_t written_ = 0;    // offset after the last byte that was handed over
};

// The upload with the offset that is really on disk. The caller has its turn. Blocks.
Upload reconciled(const Services& services, const Upload& upload);

}  // namespace divemesh::api
