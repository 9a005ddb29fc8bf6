#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace divemesh::api {

// "%2F" -> "/". Nothing for a broken escape or one that means NUL.
std::optional<std::string> percent_decode(std::string_view text);

struct Target {
    std::string path;  // still escaped: "/" within a segment is "%2F"
    std::map<std::string, std::string, std::less<>> query;
};

// Splits a request's target. Throws Error{InvalidArgument} for what is no path of ours: not
// beginning with "/", broken escapes, a name twice.
Target parse_target(std::string_view target);

// "a,b" as its parts, at least one.
std::vector<std::string> split_list(const std::string& list);

// A whole decimal number without sign that fits; nothing otherwise.
std::optional<std::int64_t> parse_count(std::string_view text);

}  // namespace divemesh::api
