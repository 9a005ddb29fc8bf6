#include "worker/dive/entry_name.hpp"

#include <algorithm>

namespace divemesh::dive {
namespace {

constexpr std::size_t kMaxNameBytes = 1024;
constexpr int kMaxFolders = 16;

bool is_control(unsigned char byte) { return byte < 0x20 || byte == 0x7f; }

// Returns the length of the well-formed UTF-8 sequence at the start of `text`; 0 if it is
// malformed.
std::size_t utf8_length(std::string_view text) {
    const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
    const auto follows = [&](std::size_t i) { return i < text.size() && (byte(i) & 0xc0) == 0x80; };
    if (byte(0) < 0x80) return 1;
    if (byte(0) >= 0xc2 && byte(0) < 0xe0) return follows(1) ? 2 : 0;
    if (byte(0) >= 0xe0 && byte(0) < 0xf0) {
        if (!follows(1) || !follows(2)) return 0;
        const bool overlong = byte(0) == 0xe0 && byte(1) < 0xa0;
        const bool surrogate = byte(0) == 0xed && byte(1) >= 0xa0;
        return overlong || surrogate ? 0 : 3;
    }
    if (byte(0) >= 0xf0 && byte(0) < 0xf5) {
        if (!follows(1) || !follows(2) || !follows(3)) return 0;
        const bool overlong = byte(0) == 0xf0 && byte(1) < 0x90;
        const bool beyond = byte(0) == 0xf4 && byte(1) >= 0x90;
        return overlong || beyond ? 0 : 4;
    }
    return 0;
}

std::string part_problem(std::string_view part) {
    if (part.empty()) return "has an empty part";
    if (part == "..") return "holds '..'";
    if (part == ".") return "holds '.'";
    return "";
}

}  // namespace

std::string printable(std::string_view text, std::size_t max_bytes) {
    constexpr char kDigits[] = "0123456789abcdef";
    std::string result;
    while (!text.empty()) {
        if (result.size() >= max_bytes) return result + "...";
        const std::size_t length = utf8_length(text);
        const auto byte = static_cast<unsigned char>(text.front());
        if (length == 0 || is_control(byte)) {
            result += {'\\', 'x', kDigits[byte >> 4], kDigits[byte & 15]};
            text.remove_prefix(1);
        } else {
            result += text.substr(0, length);
            text.remove_prefix(length);
        }
    }
    return result;
}

std::string entry_name_problem(std::string_view name) {
    if (name.empty()) return "is empty";
    if (name.size() > kMaxNameBytes) return "is longer than 1024 bytes";
    if (name.front() == '/') return "is an absolute path";
    if (name.size() > 1 && name[1] == ':') return "starts with a drive letter";
    if (name.find('\\') != std::string_view::npos) return "contains a backslash";
    if (std::any_of(name.begin(), name.end(), [](char c) {
            return is_control(static_cast<unsigned char>(c));
        }))
        return "contains a control character";
    if (std::count(name.begin(), name.end(), '/') > kMaxFolders)
        return "is more than 16 folders deep";
    for (std::size_t start = 0; start <= name.size();) {
        const std::size_t slash = std::min(name.find('/', start), name.size());
        if (auto problem = part_problem(name.substr(start, slash - start)); !problem.empty())
            return problem;
        start = slash + 1;
    }
    return "";
}

}  // namespace divemesh::dive
