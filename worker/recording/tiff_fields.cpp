#include "worker/recording/tiff_fields.hpp"

#include <algorithm>

#include "worker/dive/big_endian.hpp"

namespace divemesh::recording {
namespace {

constexpr std::uint16_t kExifDirectory = 0x8769;
constexpr std::uint16_t kShort = 3;
constexpr std::uint16_t kLong = 4;
constexpr std::size_t kField_bytes = 12;
constexpr std::size_t kInline_bytes = 4;  // a value that is not longer lies in its field

// Returns the size of one value of a type; 0 for one that TIFF 6.0 does not have.
std::uint64_t size_of_type(std::uint16_t type) {
    constexpr std::uint64_t kSizes[] = {0, 1, 1, 2, 4, 8, 1, 1, 2, 4, 8, 4, 8};
    return type < std::size(kSizes) ? kSizes[type] : 0;
}

}  // namespace

std::string_view TiffField::text() const { return data.substr(0, data.find('\0')); }

TiffFields::TiffFields(std::string_view bytes, bool is_big_endian)
    : bytes_(bytes), is_big_endian_(is_big_endian), first_(word(bytes, 4, 4).value_or(0)) {}

std::optional<TiffFields> TiffFields::of(std::string_view bytes) {
    if (bytes.starts_with(std::string_view("II*\0", 4))) return TiffFields(bytes, false);
    if (bytes.starts_with(std::string_view("MM\0*", 4))) return TiffFields(bytes, true);
    return std::nullopt;
}

std::optional<std::uint32_t> TiffFields::word(std::string_view bytes,
                                              std::size_t offset,
                                              std::size_t num_bytes) const {
    if (offset > bytes.size() || num_bytes > bytes.size() - offset) return std::nullopt;
    if (is_big_endian_)
        return static_cast<std::uint32_t>(dive::big_endian(bytes, offset, num_bytes));
    std::uint32_t value = 0;
    for (std::size_t i = num_bytes; i-- > 0;)
        value = value << 8U | static_cast<unsigned char>(bytes[offset + i]);
    return value;
}

std::optional<TiffField> TiffFields::find_exif(std::uint16_t tag) const {
    const auto pointer = find(kExifDirectory);
    const auto directory = pointer ? number(*pointer) : std::nullopt;
    return directory ? find_in(*directory, tag) : std::nullopt;
}

std::optional<TiffField> TiffFields::find_in(std::uint32_t directory, std::uint16_t tag) const {
    const auto num_fields = directory == 0 ? std::nullopt : word(bytes_, directory, 2);
    for (std::uint32_t i = 0; i < num_fields.value_or(0); ++i) {
        const std::size_t offset = directory + 2 + i * kField_bytes;
        const auto found = word(bytes_, offset, 2);
        if (!found) return std::nullopt;
        if (*found == tag) return field_at(offset);
    }
    return std::nullopt;
}

std::optional<TiffField> TiffFields::field_at(std::size_t offset) const {
    const auto tag = word(bytes_, offset, 2);
    const auto type = word(bytes_, offset + 2, 2);
    const auto count = word(bytes_, offset + 4, 4);
    const auto value = word(bytes_, offset + 8, 4);
    if (!tag || !type || !count || !value) return std::nullopt;
    TiffField field{
        static_cast<std::uint16_t>(*tag), static_cast<std::uint16_t>(*type), *count, {}};
    const std::uint64_t num_bytes = size_of_type(field.type) * field.count;
    const std::uint64_t place = num_bytes <= kInline_bytes ? offset + 8 : *value;
    if (num_bytes == 0 || place > bytes_.size() || num_bytes > bytes_.size() - place)
        return std::nullopt;
    field.data = bytes_.substr(place, num_bytes);
    return field;
}

std::optional<std::uint32_t> TiffFields::number(const TiffField& field) const {
    if (field.type == kShort) return word(field.data, 0, 2);
    if (field.type == kLong) return word(field.data, 0, 4);
    return std::nullopt;
}

}  // namespace divemesh::recording
