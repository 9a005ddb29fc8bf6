#include "api/client/tar_header.hpp"

#include <algorithm>
#include <cstdio>
#include <optional>
#include <string_view>
#include <utility>

namespace divemesh::api::client {
namespace {

constexpr std::size_t kNameBytes = 100;
constexpr std::size_t kPrefixBytes = 155;
constexpr std::int64_t kMaxUstarSize = 0x1FFFFFFFF;  // 11 octal digits

struct UstarName {
    std::string_view prefix;
    std::string_view name;
};

// Splits a name of up to 255 bytes at a slash; nullopt if no slash fits.
std::optional<UstarName> split_name(std::string_view path) {
    if (path.size() <= kNameBytes) return UstarName{"", path};
    const std::size_t slash = path.find('/', path.size() - kNameBytes - 1);
    if (slash > kPrefixBytes || slash + 1 == path.size()) return std::nullopt;  // or no slash
    return UstarName{path.substr(0, slash), path.substr(slash + 1)};
}

bool is_ascii(std::string_view text) {
    return std::all_of(
        text.begin(), text.end(), [](char c) { return static_cast<unsigned char>(c) < 0x80; });
}

void put(std::string& block, std::size_t at, std::string_view text) {
    std::copy(text.begin(), text.end(), block.begin() + static_cast<std::ptrdiff_t>(at));
}

void put_octal(std::string& block, std::size_t at, int digits, std::int64_t value) {
    char text[24];
    std::snprintf(text, sizeof text, "%0*llo", digits, static_cast<unsigned long long>(value));
    put(block, at, {text, static_cast<std::size_t>(digits)});
}

std::string ustar_block(const UstarName& name, std::int64_t size_bytes, char type) {
    std::string block(kTarBlockBytes, '\0');
    put(block, 0, name.name);
    put_octal(block, 100, 7, 0644);  // mode
    put_octal(block, 108, 7, 0);     // user
    put_octal(block, 116, 7, 0);     // group
    put_octal(block, 124, 11, size_bytes);
    put_octal(block, 136, 11, 0);  // time
    block[156] = type;
    put(block, 257, {"ustar\00000", 8});
    put(block, 345, name.prefix);
    put(block, 148, "        ");  // the checksum counts its own field as blanks
    std::int64_t sum = 0;
    for (const char c : block) sum += static_cast<unsigned char>(c);
    put_octal(block, 148, 6, sum);
    block[154] = '\0';
    return block;
}

// Returns "<length> <key>=<value>\n", where the length counts its own digits.
std::string pax_record(std::string_view key, std::string_view value) {
    std::string rest;
    rest.append(" ").append(key).append("=").append(value).append("\n");
    std::size_t length = rest.size() + 1;
    while (std::to_string(length).size() + rest.size() != length)
        length = std::to_string(length).size() + rest.size();
    return std::to_string(length) + rest;
}

}  // namespace

std::string tar_header(const std::string& path, std::int64_t size_bytes) {
    const auto name = split_name(path);
    std::string records;
    if (!name || !is_ascii(path)) records += pax_record("path", path);
    if (size_bytes > kMaxUstarSize) records += pax_record("size", std::to_string(size_bytes));
    std::string header;
    if (!records.empty()) {
        const auto length = static_cast<std::int64_t>(records.size());
        header = ustar_block({"", "pax_header"}, length, 'x') + records;
        header.append(static_cast<std::size_t>(tar_padding_bytes(length)), '\0');
    }
    const auto short_name =
        name.value_or(UstarName{"", std::string_view(path).substr(0, kNameBytes)});
    return header + ustar_block(short_name, std::min(size_bytes, kMaxUstarSize), '0');
}

}  // namespace divemesh::api::client
