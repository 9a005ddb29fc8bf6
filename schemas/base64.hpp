#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace divemesh {

// Decodes base64 with padding (RFC 4648, section 4); nullopt if it is invalid.
std::optional<std::string> decode_base64(std::string_view text);

// Encodes bytes as base64 with padding.
std::string encode_base64(std::string_view bytes);

}  // namespace divemesh
