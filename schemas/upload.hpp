#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace divemesh {

// One tus upload. `offset_bytes` never goes down and never exceeds what is durable.
struct Upload {
    std::string id;
    std::string project;
    std::int64_t length_bytes = 0;
    std::int64_t offset_bytes = 0;
    std::string metadata;  // Upload-Metadata, byte for byte as it came
    std::string blob;      // key of the staged bytes in the blob store; not shown over HTTP
    std::string dive_id;   // the dive it became; "" before
    std::int64_t created_at_ms = 0;

    bool complete() const { return offset_bytes == length_bytes; }
};

}  // namespace divemesh
