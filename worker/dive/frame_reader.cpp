#include "worker/dive/frame_reader.hpp"

#include "schemas/error.hpp"
#include "worker/dive/image_size.hpp"

namespace divemesh::dive {
namespace {

LoadedImage without_image(std::string code, std::string problem) {
    LoadedImage loaded;
    loaded.code = std::move(code);
    loaded.problem = std::move(problem);
    return loaded;
}

}  // namespace

LoadedImage load_image(const DiveFiles& files,
                       const std::string& path,
                       const types::Camera& camera,
                       const DiveLimits& limits,
                       Channels channels,
                       int reduction) {
    if (!files.has(path)) return without_image("image_missing", "the file is missing");
    const auto bytes = files.read(path, kMaxImageFileBytes);
    if (!bytes) return without_image("image_too_large", "it is larger than 64 MiB");
    try {
        const ImageHeader header = read_image_header(*bytes);
        if (header.width_px > limits.max_image_pixels / header.height_px)
            return without_image("image_too_large",
                                 "its header says " +
                                     to_string(ImageSize{header.width_px, header.height_px}) +
                                     " pixels");
        if (header.width_px != camera.width_px || header.height_px != camera.height_px)
            return without_image("image_size",
                                 "it has " +
                                     to_string(ImageSize{header.width_px, header.height_px}) +
                                     " pixels, but its calibration has " +
                                     to_string(ImageSize{camera.width_px, camera.height_px}));
        LoadedImage loaded;
        loaded.image = decode_image(*bytes, header, channels, reduction);
        loaded.was_16_bit = header.bits_per_channel > 8;
        return loaded;
    } catch (const Error& error) {
        if (error.code() != ErrorCode::BadData) throw;
        return without_image("image_undecodable", error.what());
    }
}

std::optional<LoadedPair> FrameReader::next() {
    while (next_to_load_ < num_pairs_ && std::ssize(prefetched_) < num_prefetched_)
        prefetched_.push_back(std::async(std::launch::async, load_, next_to_load_++));
    if (prefetched_.empty()) return std::nullopt;
    std::future<LoadedPair> front = std::move(prefetched_.front());
    prefetched_.pop_front();
    return front.get();
}

void FrameReader::rewind() {
    prefetched_.clear();  // waits for running tasks
    next_to_load_ = 0;
}

}  // namespace divemesh::dive
