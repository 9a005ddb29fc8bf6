#include "schemas/jpeg_header.hpp"

#include <cstddef>

#include "schemas/error.hpp"

namespace divemesh {
namespace {

// Second bytes of the markers (ITU-T T.81, table B.1).
constexpr unsigned kStartOfImage = 0xD8;
constexpr unsigned kEndOfImage = 0xD9;
constexpr unsigned kStartOfScan = 0xDA;
constexpr unsigned kBaselineFrame = 0xC0;
constexpr unsigned kProgressiveFrame = 0xC2;
constexpr unsigned kFirstRestart = 0xD0;
constexpr unsigned kTemporary = 0x01;

class Walk {
public:
    explicit Walk(std::string_view bytes) : bytes_(bytes) {}

    JpegSize size() {
        if (byte(0) != 0xFF || byte(1) != kStartOfImage)
            refuse("it does not begin with a JPEG marker");
        JpegSize size;
        for (std::size_t place = 2;;) {
            if (byte(place) != 0xFF) refuse("a marker is missing");
            while (byte(place) == 0xFF) ++place;  // fill bytes
            const unsigned marker = byte(place++);
            if (marker == kStartOfScan) break;
            if (marker == kTemporary || (marker >= kFirstRestart && marker <= kEndOfImage))
                refuse("a marker before the image data is not allowed there");
            const std::size_t length = word(place);
            if (length < 2) refuse("a segment has no length");
            if (marker >= kBaselineFrame && marker <= kProgressiveFrame)
                size = {static_cast<int>(word(place + 5)), static_cast<int>(word(place + 3))};
            place += length;
        }
        if (size.width == 0 || size.height == 0) refuse("it has no frame header with a size");
        if (byte(bytes_.size() - 2) != 0xFF || byte(bytes_.size() - 1) != kEndOfImage)
            refuse("the end of the image is missing");
        return size;
    }

private:
    [[noreturn]] static void refuse(const std::string& why) {
        throw Error(ErrorCode::InvalidArgument, "the JPEG is incomplete or damaged: " + why);
    }
    unsigned byte(std::size_t place) const {
        if (place >= bytes_.size()) refuse("its end is missing");
        return static_cast<unsigned char>(bytes_[place]);
    }
    unsigned word(std::size_t place) const { return byte(place) << 8 | byte(place + 1); }

    std::string_view bytes_;
};

}  // namespace

JpegSize read_jpeg_size(std::string_view bytes) { return Walk(bytes).size(); }

}  // namespace divemesh
