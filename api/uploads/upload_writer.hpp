#pragma once

#include <chrono>
#include <memory>
#include <optional>
#include <span>

#include "api/disk_guard.hpp"
#include "api/services.hpp"
#include "schemas/content_hash.hpp"
#include "schemas/upload.hpp"

namespace divemesh::api {

// Where the bytes of a request go. Methods block: for the pool.
class ByteSink {
public:
    virtual ~ByteSink() = default;
    virtual std::int64_t room_bytes() const = 0;
    virtual void write(std::span<const char> bytes) = 0;  // at most room_bytes()
};

// Appends to the staged bytes of one upload. What finish() has returned is on disk and in the
// catalog; offsets never go down.
class UploadWriter : public ByteSink {
public:
    // Goes on where the durable bytes end: a server that was killed may have left more of them
    // than the catalog knew. `upload` must be fresh and the caller has its turn.
    UploadWriter(Services services, Upload upload);

    const Upload& upload() const { return upload_; }
    std::int64_t room_bytes() const override;

    // Makes durable what has come every few seconds. Throws Error{OutOfSpace}, Error{OutOfQuota};
    // what fitted is kept.
    void write(std::span<const char> bytes) override;
    const Upload& finish();

private:
    void advance();

    Services services_;
    Upload upload_;
    std::unique_ptr<storage::StagedBlob> staged_;
    std::optional<Sha256> hash_;  // of everything so far, when that is known
    std::int64_t written_ = 0;    // offset after the last byte that was handed over
    std::chrono::steady_clock::time_point flushed_;
    RoomWatch room_;
};

// The upload with the offset that is really on disk. The caller has its turn. Blocks.
Upload reconciled(const Services& services, const Upload& upload);

// Removes the bytes of an upload that has ended. The caller has its turn, or nobody can. Blocks.
void free_bytes(const Services& services, const Upload& upload);

}  // namespace divemesh::api
