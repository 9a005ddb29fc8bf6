#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace divemesh::api {

struct ByteRange {
    std::int64_t offset = 0;
    std::int64_t length = 0;
};

// The part of a body that a Range header asks for; `range` is nullopt if it lies outside the body
// (416).
struct RangeAnswer {
    std::optional<ByteRange> range;
    bool partial = false;
};
// Parses a Range header for a body of `size` bytes (RFC 9110, 14.2). Returns the whole body if
// there is no header, if its unit or form is not supported, or if it asks for several ranges, which
// a server may ignore (so thousands of ranges cost nothing).
RangeAnswer parse_range(std::string_view header, std::int64_t size);

// Returns the value of Repr-Digest and Content-Digest (RFC 9530) for a SHA-256 in hex.
std::string digest_field(std::string_view sha256_hex);

// Returns a Content-Disposition whose file name no client can misread (RFC 6266, 8187).
std::string content_disposition(std::string_view type, std::string_view filename);

}  // namespace divemesh::api
