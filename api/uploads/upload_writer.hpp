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

// Takes the bytes of a request. Methods block: run them in the pool.
class ByteSink {
public:
    virtual ~ByteSink() = default;
    virtual std::int64_t room_bytes() const = 0;
    virtual void write(std::span<const char> bytes) = 0;  // at most room_bytes()
};

// Appends to the staged bytes of one upload. The upload that finish() returns is on disk and in the
// catalog; offsets never decrease.
class UploadWriter : public ByteSink {
public:
    // Continues where the durable bytes end: a killed server may have left more of them than the
    // catalog knows. `upload` must be up to date and the caller holds its lock.
    UploadWriter(Services services, Upload upload);

    const Upload& upload() const { return upload_; }
    std::int64_t room_bytes() const override;

    // Makes the bytes durable every few seconds. Throws Error{OutOfSpace}, Error{OutOfQuota}; keeps
    // the bytes that fitted.
    void write(std::span<const char> bytes) override;
    const Upload& finish();

private:
    void advance();

    Services services_;
    Upload upload_;
    std::unique_ptr<storage::StagedBlob> staged_;
    std::optional<Sha256> hash_;  // of all bytes so far; nullopt if unknown
    std::int64_t written_ = 0;    // offset after the last byte written
    std::chrono::steady_clock::time_point flushed_;
    RoomWatch room_;
};

// Returns the upload with the offset that is really on disk. The caller holds its lock. Blocks.
Upload reconciled(const Services& services, const Upload& upload);

// Removes the bytes of an upload that has ended. The caller holds its lock, or no request can take
// it. Blocks.
void free_bytes(const Services& services, const Upload& upload);

}  // namespace divemesh::api
