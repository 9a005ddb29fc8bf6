#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

namespace divemesh::recording {

// A value of a TIFF directory, the first of its kind.
struct TiffField {
    std::uint16_t tag = 0;
    std::uint16_t type = 0;
    std::uint32_t count = 0;
    std::string_view data;  // its bytes in the order of the file, in the field or elsewhere

    // Returns the text of an ASCII field up to its end mark.
    std::string_view text() const;
};

// The directories of a TIFF (TIFF 6.0, section 2), which EXIF is written in too. Only the first
// directory and the one that a field of it points to are read, each once, so directories in a
// circle do no harm; whatever lies outside of the bytes does not exist.
class TiffFields {
public:
    // Returns nullopt if the bytes do not begin as a TIFF does.
    static std::optional<TiffFields> of(std::string_view bytes);

    // Returns a field of the first directory.
    std::optional<TiffField> find(std::uint16_t tag) const { return find_in(first_, tag); }
    // Returns a field of the EXIF directory (tag 0x8769 of the first one points to it).
    std::optional<TiffField> find_exif(std::uint16_t tag) const;
    // Returns a whole number, SHORT or LONG.
    std::optional<std::uint32_t> number(const TiffField& field) const;

private:
    TiffFields(std::string_view bytes, bool is_big_endian);

    std::optional<std::uint32_t> word(std::string_view bytes,
                                      std::size_t offset,
                                      std::size_t num_bytes) const;
    std::optional<TiffField> find_in(std::uint32_t directory, std::uint16_t tag) const;
    std::optional<TiffField> field_at(std::size_t offset) const;

    std::string_view bytes_;
    bool is_big_endian_ = false;
    std::uint32_t first_ = 0;  // 0: there is none
};

}  // namespace divemesh::recording
