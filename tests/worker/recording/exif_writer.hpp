#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace divemesh::recording {

enum class ByteOrder { Little, Big };

// Writes the EXIF of a still as Exif 2.32 describes it: a TIFF whose first directory points to a
// second one, with text fields in both.
class ExifWriter {
public:
    using Texts = std::vector<std::pair<std::uint16_t, std::string>>;  // by tag, in rising order

    explicit ExifWriter(ByteOrder order) : order_(order) {}

    // Returns the TIFF: directory 0 at byte 8, the EXIF directory behind it, texts at the end.
    std::string tiff(const Texts& first, const Texts& exif) const {
        const std::size_t exif_at = 8 + size_of(first.size() + 1);
        std::size_t text_at = exif_at + size_of(exif.size());
        std::string texts;
        std::string bytes = order_ == ByteOrder::Little ? "II" : "MM";
        bytes += number(42, 2) + number(8, 4);
        bytes += number(first.size() + 1, 2);
        for (const auto& [tag, text] : first) bytes += field(tag, text, text_at, texts);
        bytes += number(0x8769, 2) + number(4, 2) + number(1, 4) + number(exif_at, 4);
        bytes += number(0, 4);
        bytes += number(exif.size(), 2);
        for (const auto& [tag, text] : exif) bytes += field(tag, text, text_at, texts);
        return bytes + number(0, 4) + texts;
    }

    // Puts EXIF into a JPEG, as the first segment behind its start.
    static std::string in_jpeg(const std::string& jpeg, const std::string& tiff) {
        const std::string segment = std::string("Exif\0\0", 6) + tiff;
        const std::size_t length = segment.size() + 2;
        std::string app1 = "\xff\xe1";
        app1 += static_cast<char>(length >> 8U);
        app1 += static_cast<char>(length & 0xffU);
        return jpeg.substr(0, 2) + app1 + segment + jpeg.substr(2);
    }

    // Returns a number of some bytes in the order of the file.
    std::string number(std::uint64_t value, std::size_t num_bytes) const {
        std::string bytes;
        for (std::size_t i = 0; i < num_bytes; ++i)
            bytes += static_cast<char>(value >>
                                       8U * (order_ == ByteOrder::Little ? i : num_bytes - 1 - i));
        return bytes;
    }

private:
    static std::size_t size_of(std::size_t num_fields) { return 2 + 12 * num_fields + 4; }

    // Returns an ASCII field; a text of more than 4 bytes with its end mark lies at the end.
    std::string field(std::uint16_t tag,
                      const std::string& text,
                      std::size_t& text_at,
                      std::string& texts) const {
        std::string value = text + '\0';
        std::string bytes = number(tag, 2) + number(2, 2) + number(value.size(), 4);
        if (value.size() <= 4) {
            value.resize(4, '\0');
            return bytes + value;
        }
        bytes += number(text_at, 4);
        text_at += value.size();
        texts += value;
        return bytes;
    }

    ByteOrder order_;
};

}  // namespace divemesh::recording
