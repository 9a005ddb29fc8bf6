#include "worker/recording/npy_array.hpp"

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <cstring>
#include <string>

#include "schemas/error.hpp"

namespace divemesh::recording {
namespace {

constexpr std::string_view kMagic = "\x93NUMPY";
constexpr std::size_t kMaxNumbers = 4096;  // a matrix of a camera has 9
constexpr std::size_t kMaxDimensions = 8;

[[noreturn]] void fail(const std::string& why) { throw Error(ErrorCode::BadData, why); }

struct NpyHeader {
    std::string_view type;  // "<f8"
    bool is_by_columns = false;
    std::vector<std::size_t> shape;
    std::string_view values;
};

// Returns what follows `'key':` in the dictionary of a header.
std::string_view value_of(std::string_view dictionary, std::string_view key) {
    const std::size_t at = dictionary.find(key);
    if (at == std::string_view::npos) fail("the header of an array lacks " + std::string(key));
    dictionary.remove_prefix(at + key.size());
    dictionary.remove_prefix(std::min(dictionary.find_first_not_of("': "), dictionary.size()));
    return dictionary;
}

// Returns the sizes of "(3, 3), ...".
std::vector<std::size_t> shape_of(std::string_view text) {
    const std::size_t end = text.find(')');
    if (!text.starts_with('(') || end == std::string_view::npos)
        fail("the header of an array states no shape");
    std::vector<std::size_t> shape;
    for (text = text.substr(1, end - 1); !text.empty();) {
        std::size_t size = 0;
        const auto [rest, problem] = std::from_chars(text.data(), text.data() + text.size(), size);
        if (problem != std::errc() || shape.size() == kMaxDimensions)
            fail("the shape of an array is not read");
        shape.push_back(size);
        text.remove_prefix(static_cast<std::size_t>(rest - text.data()));
        text.remove_prefix(std::min(text.find_first_not_of(", "), text.size()));
    }
    return shape;
}

// Splits an array into its header and its values: the length of the header has two bytes in
// version 1, four in those after it.
NpyHeader header_of(std::string_view bytes) {
    if (!bytes.starts_with(kMagic) || bytes.size() < 12) fail("an array is no file of numpy");
    const auto byte = [&](std::size_t i) { return static_cast<std::uint8_t>(bytes[i]); };
    const std::size_t start = byte(6) == 1 ? 10 : 12;
    std::size_t length = byte(8) | std::size_t{byte(9)} << 8U;
    if (start == 12) length |= std::size_t{byte(10)} << 16U | std::size_t{byte(11)} << 24U;
    if (length > bytes.size() - start) fail("the header of an array is cut");
    const std::string_view dictionary = bytes.substr(start, length);
    NpyHeader header;
    header.type = value_of(dictionary, "'descr'");
    header.type = header.type.substr(0, header.type.find('\''));
    header.is_by_columns = value_of(dictionary, "'fortran_order'").starts_with("True");
    header.shape = shape_of(value_of(dictionary, "'shape'"));
    header.values = bytes.substr(start + length);
    return header;
}

template <typename Value>
double number_at(std::string_view values, std::size_t place, bool is_big_endian) {
    char raw[sizeof(Value)];
    std::memcpy(raw, values.data() + place * sizeof(Value), sizeof raw);
    if (is_big_endian) std::reverse(raw, raw + sizeof raw);
    Value value{};
    std::memcpy(&value, raw, sizeof raw);
    return static_cast<double>(value);
}

using ReadNumber = double (*)(std::string_view, std::size_t, bool);

// Returns what reads a number of a type such as "f8"; nullptr for those that are not read.
ReadNumber reader_of(std::string_view type) {
    if (type == "f8") return number_at<double>;
    if (type == "f4") return number_at<float>;
    if (type == "i8") return number_at<std::int64_t>;
    if (type == "i4") return number_at<std::int32_t>;
    return nullptr;
}

}  // namespace

std::optional<std::vector<double>> parse_npy(std::string_view bytes) {
    NpyHeader header = header_of(bytes);
    if (header.type.size() != 3 || (header.type[0] != '<' && header.type[0] != '>'))
        return std::nullopt;
    const ReadNumber read = reader_of(header.type.substr(1));
    std::erase(header.shape, std::size_t{1});
    if (read == nullptr || header.shape.size() > 2) return std::nullopt;
    const std::size_t rows = header.shape.empty() ? 1 : header.shape[0];
    const std::size_t columns = header.shape.size() < 2 ? 1 : header.shape[1];
    if (rows > kMaxNumbers || columns > kMaxNumbers || rows * columns > kMaxNumbers)
        return std::nullopt;
    const auto size_bytes = static_cast<std::size_t>(header.type[2] - '0');
    if (header.values.size() < rows * columns * size_bytes)
        fail("an array has fewer numbers than its header states");
    std::vector<double> numbers;
    for (std::size_t row = 0; row < rows; ++row)
        for (std::size_t column = 0; column < columns; ++column)
            numbers.push_back(
                read(header.values,
                     header.is_by_columns ? column * rows + row : row * columns + column,
                     header.type[0] == '>'));
    return numbers;
}

}  // namespace divemesh::recording
