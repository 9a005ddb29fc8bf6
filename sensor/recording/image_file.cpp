#include "sensor/recording/image_file.hpp"

#include <algorithm>
#include <string>
#include <string_view>

#include "api/client/byte_source.hpp"
#include "schemas/error.hpp"
#include "worker/dive/image.hpp"

namespace divemesh::sensor {
namespace {

constexpr std::int64_t kMaxSizeBytes = std::int64_t{64} << 20;
constexpr std::int64_t kMaxImagePixels = 64'000'000;

// Returns whether the file's end is there. Decoders fill the missing rest of an image with grey and
// report no error.
bool is_whole(std::string_view bytes, dive::ImageFormat format) {
    constexpr std::string_view kJpegEnd = "\xFF\xD9";
    constexpr std::string_view kPngEnd = "IEND\xAE\x42\x60\x82";
    const bool is_png = format == dive::ImageFormat::Png;
    constexpr std::size_t kTail = 64;  // some cameras write a few bytes after the end
    const std::string_view tail = bytes.substr(bytes.size() - std::min(bytes.size(), kTail));
    return tail.rfind(is_png ? kPngEnd : kJpegEnd) != std::string_view::npos;
}

}  // namespace

cv::Mat read_image(const std::filesystem::path& file) {
    try {
        const api::client::OpenFile opened(file);
        if (opened.stamp().size_bytes > kMaxSizeBytes) return {};
        std::string bytes(static_cast<std::size_t>(opened.stamp().size_bytes), '\0');
        std::size_t done = 0;
        while (done < bytes.size()) {
            const std::size_t got = opened.read_at(static_cast<std::int64_t>(done),
                                                   {bytes.data() + done, bytes.size() - done});
            if (got == 0) return {};
            done += got;
        }
        const dive::ImageHeader header = dive::read_image_header(bytes);
        if (!is_whole(bytes, header.format) || header.width_px * header.height_px > kMaxImagePixels)
            return {};
        return dive::decode_image(
            bytes, header, header.num_channels == 1 ? dive::Channels::Grey : dive::Channels::Bgr);
    } catch (const Error&) {
        return {};
    }
}

}  // namespace divemesh::sensor
