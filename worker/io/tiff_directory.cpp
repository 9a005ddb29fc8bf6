#include "worker/io/tiff_directory.hpp"

#include <bit>

namespace divemesh::io {
namespace {

static_assert(std::endian::native == std::endian::little);  // as the files

// Types of values in TIFF 6.0 and BigTIFF.
constexpr std::uint16_t kAscii = 2;
constexpr std::uint16_t kShort = 3;
constexpr std::uint16_t kLong = 4;
constexpr std::uint16_t kDouble = 12;
constexpr std::uint16_t kLong8 = 16;

template <typename Number>
void append(std::string& bytes, Number number) {
    bytes.append(reinterpret_cast<const char*>(&number), sizeof number);
}

template <typename Number>
std::string bytes_of(const std::vector<Number>& values) {
    std::string bytes;
    for (const Number value : values) append(bytes, value);
    return bytes;
}

// A number that is 4 bytes wide in a classic TIFF and 8 in a big one.
void append_wide(std::string& bytes, std::uint64_t number, TiffVariant variant) {
    if (variant == TiffVariant::Big)
        append(bytes, number);
    else
        append(bytes, static_cast<std::uint32_t>(number));
}

std::uint64_t wide_bytes(TiffVariant variant) { return variant == TiffVariant::Big ? 8 : 4; }

// Values begin at even offsets.
std::uint64_t padded(std::uint64_t num_bytes) { return num_bytes + num_bytes % 2; }

}  // namespace

void TiffDirectory::set_shorts(std::uint16_t tag, const std::vector<std::uint16_t>& values) {
    fields_[tag] = {kShort, values.size(), bytes_of(values)};
}

void TiffDirectory::set_longs(std::uint16_t tag, const std::vector<std::uint32_t>& values) {
    fields_[tag] = {kLong, values.size(), bytes_of(values)};
}

void TiffDirectory::set_doubles(std::uint16_t tag, const std::vector<double>& values) {
    fields_[tag] = {kDouble, values.size(), bytes_of(values)};
}

void TiffDirectory::set_text(std::uint16_t tag, std::string_view text) {
    std::string value(text);
    value.push_back('\0');
    const std::uint64_t count = value.size();
    fields_[tag] = {kAscii, count, std::move(value)};
}

void TiffDirectory::set_offsets(std::uint16_t tag,
                                const std::vector<std::uint64_t>& values,
                                TiffVariant variant) {
    std::string bytes;
    for (const std::uint64_t value : values) append_wide(bytes, value, variant);
    const std::uint16_t type = variant == TiffVariant::Big ? kLong8 : kLong;
    fields_[tag] = {type, values.size(), std::move(bytes)};
}

std::uint64_t TiffDirectory::num_bytes(TiffVariant variant) const {
    return bytes(variant, 0, 0).size();
}

std::string TiffDirectory::bytes(TiffVariant variant,
                                 std::uint64_t offset,
                                 std::uint64_t next) const {
    const std::uint64_t wide = wide_bytes(variant);
    const std::uint64_t field_bytes = 4 + 2 * wide;
    const std::uint64_t count_bytes = variant == TiffVariant::Big ? 8 : 2;
    std::uint64_t place = offset + padded(count_bytes + fields_.size() * field_bytes + wide);
    std::string directory;
    if (variant == TiffVariant::Big)
        append(directory, static_cast<std::uint64_t>(fields_.size()));
    else
        append(directory, static_cast<std::uint16_t>(fields_.size()));
    std::string values;
    for (const auto& [tag, field] : fields_) {
        append(directory, tag);
        append(directory, field.type);
        append_wide(directory, field.count, variant);
        if (field.value.size() <= wide) {
            directory += field.value;
            directory.append(wide - field.value.size(), '\0');
            continue;
        }
        append_wide(directory, place + values.size(), variant);
        values += field.value;
        values.resize(padded(values.size()), '\0');
    }
    append_wide(directory, next, variant);
    directory.resize(padded(directory.size()), '\0');
    return directory + values;
}

}  // namespace divemesh::io
