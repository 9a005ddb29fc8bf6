#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace divemesh {

// How an upload ended before it became a dive.
enum class UploadEnd {
    Terminated,    // by its client
    Expired,       // no byte came within its lifetime
    Concatenated,  // its bytes are part of another upload
};

// One tus upload. `offset_bytes` never decreases and never exceeds the durable bytes.
struct Upload {
    std::string id;
    std::string project;
    std::string token_id;                      // that began it; not shown over HTTP
    std::optional<std::int64_t> length_bytes;  // nullopt: sent later (Upload-Defer-Length)
    std::int64_t offset_bytes = 0;
    std::string metadata;  // Upload-Metadata, byte for byte as received
    std::string concat;    // Upload-Concat as received: "", "partial" or "final;..."
    std::string blob;      // key of the staged bytes in the blob store; not shown over HTTP
    std::string dive_id;   // the dive it became, or the dive of its truth; "" before
    std::string truth_id;  // the truth file it became; "" before and for a dive
    std::int64_t created_at_ms = 0;
    std::int64_t lifetime_ms = 604'800'000;  // without a byte; a week
    std::int64_t expires_at_ms = 0;          // 0: never, because it is a dive
    std::optional<UploadEnd> end;            // nullopt: open, or a dive

    bool complete() const { return length_bytes == offset_bytes; }
    bool is_partial() const { return concat == "partial"; }
    bool is_final() const { return concat.starts_with("final;"); }
};

}  // namespace divemesh
