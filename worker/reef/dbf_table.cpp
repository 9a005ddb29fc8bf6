#include "worker/reef/dbf_table.hpp"

#include <cstdint>
#include <nlohmann/json.hpp>

#include "schemas/error.hpp"
#include "worker/reef/little_endian.hpp"

namespace divemesh::reef {
namespace {

constexpr std::size_t kDescriptor_bytes = 32;  // of the file, and of each column
constexpr char kEndOfColumns = '\r';

struct Column {
    std::string name;
    std::size_t offset = 0;
    std::size_t length = 0;
};

// Returns the text with what ends or begins something in JSON replaced.
std::string hidden(std::string text) {
    for (char& c : text)
        if (c == '"' || c == '\\' || static_cast<unsigned char>(c) < 0x20U) c = '.';
    return text;
}

bool is_utf8(const std::string& text) { return nlohmann::json::accept('"' + hidden(text) + '"'); }

std::string utf8_of_latin1(const std::string& text) {
    std::string utf8;
    for (const char c : text) {
        const auto byte = static_cast<unsigned char>(c);
        if (byte < 0x80U) {
            utf8 += c;
        } else {
            utf8 += static_cast<char>(0xc0U | (byte >> 6U));
            utf8 += static_cast<char>(0x80U | (byte & 0x3fU));
        }
    }
    return utf8;
}

std::string cell(std::string_view field) {
    const std::string_view blanks(" \0", 2);
    const std::size_t first = field.find_first_not_of(blanks);
    if (first == std::string_view::npos) return "";
    const std::string text(field.substr(first, field.find_last_not_of(blanks) - first + 1));
    return is_utf8(text) ? text : utf8_of_latin1(text);
}

[[noreturn]] void refuse(const char* what) {
    throw Error(ErrorCode::BadData, std::string("the table of its columns (.dbf) ") + what);
}

std::vector<Column> read_columns(std::string_view bytes, std::size_t row_bytes) {
    std::vector<Column> columns;
    std::size_t offset = 1;  // behind the mark of a deleted row
    for (std::size_t at = kDescriptor_bytes; at < bytes.size() && bytes[at] != kEndOfColumns;
         at += kDescriptor_bytes) {
        if (at + kDescriptor_bytes > bytes.size()) refuse("ends within its columns");
        const std::string_view name = bytes.substr(at, 11);
        const std::size_t length = static_cast<unsigned char>(bytes[at + 16]);
        columns.push_back({cell(name.substr(0, name.find('\0'))), offset, length});
        offset += length;
    }
    if (offset > row_bytes) refuse("has rows shorter than its columns");
    return columns;
}

}  // namespace

DbfTable read_dbf(std::string_view bytes) {
    if (bytes.size() < kDescriptor_bytes) refuse("is too short");
    const std::size_t num_rows = little_endian_at<std::uint32_t>(bytes, 4);
    const std::size_t header_bytes = little_endian_at<std::uint16_t>(bytes, 8);
    const std::size_t row_bytes = little_endian_at<std::uint16_t>(bytes, 10);
    if (header_bytes > bytes.size() || row_bytes == 0 ||
        num_rows > (bytes.size() - header_bytes) / row_bytes)
        refuse("is shorter than its header announces: copy the file again");
    const std::vector<Column> columns = read_columns(bytes.substr(0, header_bytes), row_bytes);
    DbfTable table(num_rows);
    for (std::size_t row = 0; row < num_rows; ++row)
        for (const Column& column : columns)
            table[row][column.name] =
                cell(bytes.substr(header_bytes + row * row_bytes + column.offset, column.length));
    return table;
}

}  // namespace divemesh::reef
