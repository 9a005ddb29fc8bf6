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

// A request's target, split into path and query, and the host of the absolute form.
struct Target {
    std::string path;  // still escaped: "/" within a segment is "%2F"
    std::map<std::string, std::string, std::less<>> query;
    std::string host;  // of "http://HOST/path"; "" for "/path"
};

// Splits a request's target, in origin or absolute form (RFC 9112, 3.2). Throws
// Error{InvalidArgument} for an invalid target: another form, an invalid host, a broken escape, a
// query name given twice.
Target parse_target(std::string_view target);

// Returns the text of a query, "a=1&b=2", in the order of the names.
std::string query_text(const std::map<std::string, std::string, std::less<>>& query);

// Returns whether a text is a host with or without a port, as the field Host has it (RFC
// 9110, 7.2).
bool is_host(std::string_view text);

// Splits "a,b" into its parts, at least one.
std::vector<std::string> split_list(const std::string& list);

// Parses a whole decimal number without a sign; nullopt if it is invalid or too large.
std::optional<std::int64_t> parse_count(std::string_view text);

}  // namespace divemesh::api
