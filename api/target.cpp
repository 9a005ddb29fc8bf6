#include "api/target.hpp"

#include <algorithm>
#include <boost/beast/core/string.hpp>
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

std::string escaped(std::string_view text) {
    constexpr char kDigits[] = "0123456789ABCDEF";
    std::string result;
    for (const char c : text) {
        const auto byte = static_cast<unsigned char>(c);
        if (std::isalnum(byte) != 0 || c == '-' || c == '_' || c == '.')
            result += c;
        else
            result += {'%', kDigits[byte >> 4], kDigits[byte & 15]};
    }
    return result;
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

bool is_digit(char c) { return c >= '0' && c <= '9'; }

bool is_hex_digit(char c) {
    return is_digit(c) || (c >= 'a' && c <= 'f') || (c >= 'A' && c <= 'F');
}

// An empty port means the usual one.
bool is_port(std::string_view text) {
    constexpr std::int64_t kMaxPort = 65535;
    return text.empty() || (std::all_of(text.begin(), text.end(), is_digit) &&
                            parse_count(text).value_or(kMaxPort + 1) <= kMaxPort);
}

// Returns whether it is an IPv6 address, without its brackets, by its characters.
bool is_ipv6(std::string_view text) {
    return text.find(':') != std::string_view::npos &&
           std::all_of(text.begin(), text.end(), [](char c) {
               return is_hex_digit(c) || c == ':' || c == '.';
           });
}

// Returns whether it is a name or an IPv4 address (RFC 3986, 3.2.2), without the comma that would
// join two fields.
bool is_name(std::string_view text) {
    const auto is_plain = [](char c) {
        return is_digit(c) || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') ||
               std::string_view("-._~!$&'()*+;=%").find(c) != std::string_view::npos;
    };
    return !text.empty() && std::all_of(text.begin(), text.end(), is_plain) &&
           percent_decode(text).has_value();
}

// Takes "http://HOST" off the absolute form and returns the host; "" for the origin form.
std::string take_host(std::string_view& target) {
    if (target.starts_with('/')) return "";
    const auto colon = std::min(target.find("://"), target.size());
    const auto scheme = target.substr(0, colon);
    if (!boost::beast::iequals(scheme, "http") && !boost::beast::iequals(scheme, "https"))
        throw Error(ErrorCode::InvalidArgument, "the address must begin with / or http://");
    target.remove_prefix(std::min(target.size(), colon + 3));
    const auto host = target.substr(0, target.find_first_of("/?"));
    if (!is_host(host))
        throw Error(ErrorCode::InvalidArgument,
                    "the host in the address is invalid: send http://HOST:PORT/...");
    target.remove_prefix(host.size());
    return std::string(host);
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

std::string query_text(const std::map<std::string, std::string, std::less<>>& query) {
    std::string text;
    for (const auto& [name, value] : query) {
        if (!text.empty()) text += '&';
        text += escaped(name);
        text += '=';
        text += escaped(value);
    }
    return text;
}

Target parse_target(std::string_view target) {
    Target result;
    result.host = take_host(target);
    const auto question = target.find('?');
    result.path = target.substr(0, question);
    if (result.path.empty()) result.path.push_back('/');
    if (question != std::string_view::npos) result.query = parse_query(target.substr(question + 1));
    return result;
}

bool is_host(std::string_view text) {
    const bool is_bracketed = text.starts_with('[');
    const auto end = is_bracketed ? text.find(']') : std::min(text.find(':'), text.size());
    if (end == std::string_view::npos) return false;
    const auto rest = text.substr(is_bracketed ? end + 1 : end);
    if (!rest.empty() && (rest.front() != ':' || !is_port(rest.substr(1)))) return false;
    return is_bracketed ? is_ipv6(text.substr(1, end - 1)) : is_name(text.substr(0, end));
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
