#include "api/target.hpp"

#include <algorithm>
#include <charconv>

#include "schemas/error.hpp"

namespace divemesh::api {
namespace {

std::string unescaped(std::string_view text) {
    auto plain = percent_decode(text);
    if (!plain)
        throw Error(ErrorCode::InvalidArgument,
                    "a % in the address must be followed by two hex digits of a character");
    return std::move(*plain);
}

std::map<std::string, std::string, std::less<>> parse_query(std::string_view text) {
    std::map<std::string, std::string, std::less<>> query;
    while (!text.empty()) {
        const auto pair = text.substr(0, text.find('&'));
        text.remove_prefix(std::min(text.size(), pair.size() + 1));
        if (pair.empty()) continue;
        const auto equals = pair.find('=');
        std::string name = unescaped(pair.substr(0, equals));
        std::string value =
            equals == std::string_view::npos ? "" : unescaped(pair.substr(equals + 1));
        if (!query.emplace(name, std::move(value)).second)
            throw Error(ErrorCode::InvalidArgument,
                        "the address has \"" + name + "\" twice: give it once");
    }
    return query;
}

}  // namespace

std::optional<std::string> percent_decode(std::string_view text) {
    std::string plain;
    for (std::size_t i = 0; i < text.size(); ++i) {
        if (text[i] != '%') {
            plain += text[i];
            continue;
        }
        unsigned value = 0;
        const char* digits = text.data() + i + 1;
        if (text.size() - i < 3) return std::nullopt;
        const auto [end, failure] = std::from_chars(digits, digits + 2, value, 16);
        if (failure != std::errc{} || end != digits + 2 || value == 0) return std::nullopt;
        plain += static_cast<char>(value);
        i += 2;
    }
    return plain;
}

Target parse_target(std::string_view target) {
    if (!target.starts_with('/'))
        throw Error(ErrorCode::InvalidArgument, "the address must begin with /");
    const auto question = target.find('?');
    Target result{std::string(target.substr(0, question)), {}};
    if (question != std::string_view::npos) result.query = parse_query(target.substr(question + 1));
    return result;
}

std::optional<std::int64_t> parse_count(std::string_view text) {
    std::int64_t value = 0;
    const auto [end, failure] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (failure != std::errc{} || end != text.data() + text.size() || text.starts_with('-'))
        return std::nullopt;
    return value;
}

std::vector<std::string> split_list(const std::string& list) {
    std::vector<std::string> parts;
    for (std::size_t start = 0; start <= list.size();) {
        const auto end = std::min(list.find(',', start), list.size());
        parts.push_back(list.substr(start, end - start));
        start = end + 1;
    }
    return parts;
}

}  // namespace divemesh::api
