#include "storage/blob_key.hpp"

#include <algorithm>

#include "schemas/error.hpp"

namespace divemesh::storage {
namespace {

constexpr std::size_t kMaxKeyBytes = 512;
constexpr std::size_t kMaxPartBytes = 200;

bool is_allowed(char c) {
    return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '.' || c == '_' || c == '-';
}

bool is_part(std::string_view part) {
    return !part.empty() && part.size() <= kMaxPartBytes && part != "." && part != ".." &&
           std::all_of(part.begin(), part.end(), is_allowed);
}

// Returns a printable form of a key that may hold any bytes.
std::string printable(std::string_view key) {
    std::string text(key.substr(0, 80));
    std::replace_if(
        text.begin(), text.end(), [](char c) { return c < ' ' || c > '~'; }, '?');
    return text;
}

}  // namespace

std::vector<std::string> split_key(std::string_view key) {
    std::vector<std::string> parts;
    for (std::size_t begin = 0; begin <= key.size();) {
        const auto end = std::min(key.find('/', begin), key.size());
        const auto part = key.substr(begin, end - begin);
        if (!is_part(part) || key.size() > kMaxKeyBytes)
            throw Error(ErrorCode::InvalidArgument,
                        "invalid name for stored data: '" + printable(key) +
                            "': use a-z 0-9 . _ - and single slashes between them");
        parts.emplace_back(part);
        begin = end + 1;
    }
    return parts;
}

std::string folder_of_prefix(const std::string& prefix) {
    if (!prefix.ends_with('/'))
        throw Error(ErrorCode::InvalidArgument, "a prefix of blobs ends with a slash: " + prefix);
    std::string folder = prefix.substr(0, prefix.size() - 1);
    split_key(folder);
    return folder;
}

}  // namespace divemesh::storage
