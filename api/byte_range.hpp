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

// What a Range header asks of a body of `size` bytes (RFC 9110, 14.2): all of it when there is no
// header, its unit or form is not ours, or it asks for several, which a server may ignore (S22:
// thousands of them cost nothing); nothing when it lies outside (416).
struct RangeAnswer {
    std::optional<ByteRange> range;
    bool partial = false;
};
RangeAnswer parse_range(std::string_view header, std::int64_t size);

// The value of Repr-Digest and Content-Digest (RFC 9530) for a SHA-256 in hex.
std::string digest_field(std::string_view sha256_hex);

// Content-Disposition whose file name no client can misread (RFC 6266, 8187).
std::string content_disposition(std::string_view type, std::string_view filename);

}  // namespace divemesh::api
