#include "worker/recording/exif_time.hpp"

#include "schemas/trimmed.hpp"
#include "worker/dive/big_endian.hpp"
#include "worker/recording/civil_time.hpp"
#include "worker/recording/tiff_fields.hpp"

namespace divemesh::recording {
namespace {

constexpr std::string_view kExifMark = std::string_view("Exif\0\0", 6);
constexpr std::string_view kPngSignature = "\x89PNG\r\n\x1a\n";
constexpr std::size_t kMaxText_bytes = 64;  // a date has 20

// The tags of a time: of the whole seconds, their fraction and the zone.
struct TimeTags {
    std::uint16_t date_time;
    std::uint16_t fraction;
    std::uint16_t zone;
};
constexpr TimeTags kOriginal = {0x9003, 0x9291, 0x9011};
constexpr TimeTags kChanged = {0x0132, 0x9290, 0x9010};  // its date is in the first directory

// Returns the EXIF of a JPEG: the APP1 segment that begins with its mark (Exif 2.32, 4.7.2).
std::string_view exif_of_jpeg(std::string_view bytes) {
    constexpr unsigned char kApp1 = 0xe1;
    constexpr unsigned char kStartOfScan = 0xda;
    for (std::size_t at = 2; at + 4 <= bytes.size();) {
        const auto marker = static_cast<unsigned char>(bytes[at + 1]);
        if (static_cast<unsigned char>(bytes[at]) != 0xff || marker == kStartOfScan) return {};
        if (marker == 0xff) {  // fill byte
            ++at;
            continue;
        }
        const auto length = static_cast<std::size_t>(dive::big_endian(bytes, at + 2, 2));
        if (length < 2 || length > bytes.size() - at - 2) return {};
        const std::string_view segment = bytes.substr(at + 4, length - 2);
        if (marker == kApp1 && segment.starts_with(kExifMark))
            return segment.substr(kExifMark.size());
        at += 2 + length;
    }
    return {};
}

// Returns the EXIF of a PNG: its chunk eXIf (PNG specification, third edition, 11.3.4.5).
std::string_view exif_of_png(std::string_view bytes) {
    constexpr std::size_t kFrame_bytes = 12;  // length, type and checksum of a chunk
    for (std::size_t at = kPngSignature.size(); at + kFrame_bytes <= bytes.size();) {
        const auto length = static_cast<std::size_t>(dive::big_endian(bytes, at, 4));
        if (length > bytes.size() - at - kFrame_bytes) return {};
        if (bytes.substr(at + 4, 4) == "eXIf") return bytes.substr(at + 8, length);
        at += kFrame_bytes + length;
    }
    return {};
}

std::string_view exif_of(std::string_view image) {
    if (image.starts_with("\xff\xd8\xff")) return exif_of_jpeg(image);
    if (image.starts_with(kPngSignature)) return exif_of_png(image);
    return image;
}

std::string_view text_of(const std::optional<TiffField>& field) {
    return field ? trimmed(field->text().substr(0, kMaxText_bytes)) : std::string_view();
}

std::optional<ExifTime> time_of(std::string_view date_time,
                                const TimeTags& tags,
                                const TiffFields& fields) {
    const auto civil_ns = parse_civil_time(date_time);
    if (!civil_ns) return std::nullopt;
    const auto fraction_ns = parse_fraction_ns(text_of(fields.find_exif(tags.fraction)));
    const auto zone_ns = parse_zone_ns(text_of(fields.find_exif(tags.zone)));
    ExifTime time;
    time.timestamp_ns = *civil_ns + fraction_ns.value_or(0) - zone_ns.value_or(0);
    time.has_fraction = fraction_ns.has_value();
    return time.timestamp_ns >= 0 ? std::optional(time) : std::nullopt;
}

}  // namespace

std::optional<ExifTime> exif_time(std::string_view image) {
    const auto fields = TiffFields::of(exif_of(image));
    if (!fields) return std::nullopt;
    const auto original =
        time_of(text_of(fields->find_exif(kOriginal.date_time)), kOriginal, *fields);
    return original ? original
                    : time_of(text_of(fields->find(kChanged.date_time)), kChanged, *fields);
}

}  // namespace divemesh::recording
