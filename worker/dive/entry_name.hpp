#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace divemesh::dive {

// Returns untrusted text in a form safe for messages: valid UTF-8 without control characters,
// cut after `max_bytes`.
std::string printable(std::string_view text, std::size_t max_bytes = 200);

// Returns why `name` is not allowed as a name of a dive's file ("holds '..'"); "" if it is allowed:
// relative, '/' between plain parts, no backslash, no control character, at most 1024 bytes and 16
// folders.
std::string entry_name_problem(std::string_view name);

}  // namespace divemesh::dive
