#include "worker/io/atlas_images.hpp"

#include <algorithm>
#include <string>

#include "schemas/error.hpp"
#include "worker/io/jpeg.hpp"
#include "worker/io/mesh_check.hpp"

namespace divemesh::io {
namespace {

constexpr std::size_t kMaxDecoded_bytes = std::size_t{1} << 29;  // what all atlases of a dive have

[[noreturn]] void fail(std::size_t atlas, const std::string& problem) {
    throw Error(ErrorCode::BadData,
                "image " + std::to_string(atlas) + " of the texture " + problem +
                    ": copy the whole reconstruction again");
}

cv::Size checked_size(std::size_t atlas, std::string_view jpeg) {
    const auto size = jpeg_size(jpeg);
    if (!size || size->empty()) fail(atlas, "is not a JPEG file");
    if (std::max(size->width, size->height) > kMaxAtlas_px)
        fail(atlas, "has more than " + std::to_string(kMaxAtlas_px) + " px a side");
    return *size;
}

}  // namespace

AtlasImages::AtlasImages(const StoredTexture& texture) : texture_(texture) {
    for (const std::string& jpeg : texture.jpegs)
        sizes_.push_back(checked_size(sizes_.size(), jpeg));
}

cv::Mat AtlasImages::image(std::int32_t atlas) {
    const auto found = std::find_if(decoded_.begin(), decoded_.end(), [&](const Decoded& decoded) {
        return decoded.atlas == atlas;
    });
    if (found != decoded_.end()) {
        decoded_.splice(decoded_.begin(), decoded_, found);
        return decoded_.front().image;
    }
    std::size_t size_bytes = 3 * static_cast<std::size_t>(size(atlas).area());
    for (const Decoded& decoded : decoded_) size_bytes += decoded.image.total() * 3;
    for (; size_bytes > kMaxDecoded_bytes && !decoded_.empty(); decoded_.pop_back())
        size_bytes -= decoded_.back().image.total() * 3;
    const cv::Mat image = decode_jpeg(texture_.jpegs[atlas]);
    if (image.size() != size(atlas)) fail(atlas, "cannot be decoded");
    decoded_.push_front({atlas, image});
    return image;
}

}  // namespace divemesh::io
