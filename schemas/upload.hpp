#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace divemesh {

// How an upload came to its end before it was a dive.
enum class UploadEnd {
    Terminated,    // its client gave it up
    Expired,       // no byte came for its lifetime
    Concatenated,  // its bytes are part of another one now
};

// One tus upload. `offset_bytes` never goes down and never exceeds what is durable.
struct Upload {
    std::string id;
    std::string project;
    std::string token_id;                      // that it was begun with; not shown over HTTP
    std::optional<std::int64_t> length_bytes;  // nothing: told later (Upload-Defer-Length)
    std::int64_t offset_bytes = 0;
    std::string metadata;  // Upload-Metadata, byte for byte as it came
    std::string concat;    // Upload-Concat as it came: "", "partial" or "final;..."
    std::string blob;      // key of the staged bytes in the blob store; not shown over HTTP
    std::string dive_id;   // the dive it became, or whose truth; "" before
    std::string truth_id;  // the truth file that it became; "" before and for a dive
    std::int64_t created_at_ms = 0;
    std::int64_t lifetime_ms = 604'800'000;  // without a byte; a week
    std::int64_t expires_at_ms = 0;          // 0: never, it is a dive
    std::optional<UploadEnd> end;            // nothing: it is open, or a dive

    bool complete() const { return length_bytes == offset_bytes; }
    bool is_partial() const { return concat == "partial"; }
    bool is_final() const { return concat.starts_with("final;"); }
};

}  // namespace divemesh
