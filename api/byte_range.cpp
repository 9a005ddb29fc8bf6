#include "api/byte_range.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <limits>
#include <openssl/evp.h>

#include "api/target.hpp"

namespace divemesh::api {

namespace {

// Parses as parse_count does, but returns the max for a larger number: an offset beyond the end of
// any file.
std::optional<std::int64_t> parse_place(std::string_view digits) {
    const auto is_digit = [](char c) { return c >= '0' && c <= '9'; };
    const auto count = parse_count(digits);
    if (count || digits.empty() || !std::all_of(digits.begin(), digits.end(), is_digit))
        return count;
    return std::numeric_limits<std::int64_t>::max();
}

bool is_in_bytes(std::string_view header, std::string_view unit) {
    return header.size() >= unit.size() &&
           std::equal(unit.begin(), unit.end(), header.begin(), [](char expected, char c) {
               return expected == std::tolower(static_cast<unsigned char>(c));
           });
}

}  // namespace

RangeAnswer parse_range(std::string_view header, std::int64_t size) {
    const RangeAnswer whole{ByteRange{0, size}, false};
    constexpr std::string_view kUnit = "bytes=";
    if (!is_in_bytes(header, kUnit)) return whole;
    header.remove_prefix(kUnit.size());
    const auto dash = header.find('-');
    if (dash == std::string_view::npos || header.find(',') != std::string_view::npos) return whole;
    const auto first = parse_place(header.substr(0, dash));
    const auto last = parse_place(header.substr(dash + 1));
    if (dash == 0) {  // the last bytes, so many
        if (!last) return whole;
        if (*last == 0 || size == 0) return {std::nullopt, true};
        const std::int64_t length = std::min(*last, size);
        return {ByteRange{size - length, length}, true};
    }
    if (!first || (!last && dash + 1 != header.size()) || (last && *last < *first)) return whole;
    if (*first >= size) return {std::nullopt, true};
    const std::int64_t end = last ? std::min(*last, size - 1) : size - 1;
    return {ByteRange{*first, end - *first + 1}, true};
}

std::string digest_field(std::string_view sha256_hex) {
    std::array<unsigned char, 32> bytes{};
    for (std::size_t i = 0; i < bytes.size(); ++i)
        std::from_chars(sha256_hex.data() + 2 * i, sha256_hex.data() + 2 * i + 2, bytes[i], 16);
    std::array<unsigned char, 45> text{};
    EVP_EncodeBlock(text.data(), bytes.data(), static_cast<int>(bytes.size()));
    return "sha-256=:" + std::string(reinterpret_cast<const char*>(text.data())) + ":";
}

std::string content_disposition(std::string_view type, std::string_view filename) {
    constexpr char kDigits[] = "0123456789ABCDEF";
    filename.remove_prefix(filename.find_last_of('/') + 1);
    std::string plain;
    std::string encoded;
    for (const char c : filename) {
        const auto byte = static_cast<unsigned char>(c);
        const bool safe = std::isalnum(byte) != 0 || c == '.' || c == '_' || c == '-';
        plain += safe ? c : '_';
        if (safe)
            encoded += c;
        else
            encoded += {'%', kDigits[byte >> 4], kDigits[byte & 15]};
    }
    return std::string(type) + "; filename=\"" + plain + "\"; filename*=UTF-8''" + encoded;
}

}  // namespace divemesh::api
