#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace divemesh::api {

// Decodes "%2F" to "/". Returns nullopt for a broken escape or one that means NUL.
std::optional<std::string> percent_decode(std::string_view text);

// A request's target, split into path and query.
struct Target {
    std::string path;  // still escaped: "/" within a segment is "%2F"
    std::map<std::string, std::string, std::less<>> query;
};

// Splits a request's target. Throws Error{InvalidArgument} for an invalid target: no "/" at its
// start, a broken escape, a query name given twice.
Target parse_target(std::string_view target);

// Splits "a,b" into its parts, at least one.
std::vector<std::string> split_list(const std::string& list);

// Parses a whole decimal number without a sign; nullopt if it is invalid or too large.
std::optional<std::int64_t> parse_count(std::string_view text);

}  // namespace divemesh::api
