#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace divemesh::io {

// The width of the offsets in a TIFF: up to 4 GiB of file, or any size.
enum class TiffVariant { Classic, Big };

// An image file directory of a little-endian TIFF: its tags, in their order, with their values.
class TiffDirectory {
public:
    void set_shorts(std::uint16_t tag, const std::vector<std::uint16_t>& values);
    void set_longs(std::uint16_t tag, const std::vector<std::uint32_t>& values);
    void set_doubles(std::uint16_t tag, const std::vector<double>& values);
    void set_text(std::uint16_t tag, std::string_view text);
    // Sets offsets into the file, whose width is the variant's.
    void set_offsets(std::uint16_t tag,
                     const std::vector<std::uint64_t>& values,
                     TiffVariant variant);

    std::uint64_t num_bytes(TiffVariant variant) const;
    // Returns the directory as it lies at `offset`, followed by the values that do not fit into it;
    // `next` is the offset of the directory after it, or 0.
    std::string bytes(TiffVariant variant, std::uint64_t offset, std::uint64_t next) const;

private:
    struct TiffField {
        std::uint16_t type = 0;
        std::uint64_t count = 0;
        std::string value;
    };

    std::map<std::uint16_t, TiffField> fields_;
};

}  // namespace divemesh::io
