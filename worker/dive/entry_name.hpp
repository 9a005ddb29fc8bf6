#pragma once

#include <string>
#include <string_view>

namespace divemesh::dive {

// Text from outside as it may stand in a message: valid UTF-8 without control characters, short.
std::string printable(std::string_view text);

// Why `name` may not name a file of a dive ("holds '..'"); "" when it may: relative, '/' between
// plain parts, no backslash, no control character, at most 1024 bytes and 16 folders.
std::string entry_name_problem(std::string_view name);

}  // namespace divemesh::dive
