#include "worker/dive/frame_reader.hpp"

#include "schemas/error.hpp"

namespace divemesh::worker {
namespace {

constexpr std::int64_t kMaxPictureBytes = std::int64_t{64} << 20;

std::string size_text(std::int64_t width, std::int64_t height) {
    return std::to_string(width) + "x" + std::to_string(height);
}

LoadedPicture without_picture(std::string code, std::string problem) {
    LoadedPicture picture;
    picture.code = std::move(code);
    picture.problem = std::move(problem);
    return picture;
}

}  // namespace

LoadedPicture load_picture(const DiveFiles& files,
                           const std::string& path,
                           const Camera& camera,
                           const DiveLimits& limits,
                           Channels channels) {
    if (!files.has(path)) return without_picture("image_missing", "the file is missing");
    const auto bytes = files.read(path, kMaxPictureBytes);
    if (!bytes) return without_picture("image_too_large", "it is larger than 64 MiB");
    try {
        const ImageHeader header = read_image_header(*bytes);
        if (header.width_px > limits.max_image_pixels / header.height_px)
            return without_picture(
                "image_too_large",
                "its header says " + size_text(header.width_px, header.height_px) + " pixels");
        if (header.width_px != camera.width_px || header.height_px != camera.height_px)
            return without_picture("image_size",
                                   "it has " + size_text(header.width_px, header.height_px) +
                                       " pixels, but its calibration has " +
                                       size_text(camera.width_px, camera.height_px));
        LoadedPicture picture;
        picture.image = decode_image(*bytes, header, channels);
        picture.was_16_bit = header.bits_per_channel > 8;
        return picture;
    } catch (const Error& error) {
        if (error.code() != ErrorCode::BadData) throw;
        return without_picture("image_undecodable", error.what());
    }
}

std::optional<LoadedPair> FrameReader::next() {
    while (next_to_load_ < num_pairs_ && std::ssize(ahead_) < num_ahead_)
        ahead_.push_back(std::async(std::launch::async, load_, next_to_load_++));
    if (ahead_.empty()) return std::nullopt;
    std::future<LoadedPair> front = std::move(ahead_.front());
    ahead_.pop_front();
    return front.get();
}

void FrameReader::rewind() {
    ahead_.clear();  // waits for what is under way
    next_to_load_ = 0;
}

}  // namespace divemesh::worker
