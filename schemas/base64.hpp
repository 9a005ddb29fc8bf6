#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace divemesh {

// RFC 4648, section 4, with padding. Nothing for what is not base64.
std::optional<std::string> decode_base64(std::string_view text);

// The other way.
std::string encode_base64(std::string_view bytes);

}  // namespace divemesh
