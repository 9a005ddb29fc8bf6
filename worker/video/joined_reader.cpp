#include "worker/video/joined_reader.hpp"

#include <utility>

namespace divemesh::video {

JoinedReader::JoinedReader(std::vector<VideoPart> parts,
                           std::vector<std::int64_t> stamps_ns,
                           StoredJpeg stored_jpeg)
    : parts_(std::move(parts)), stamps_ns_(std::move(stamps_ns)), stored_jpeg_(stored_jpeg) {
    open(0);
}

std::optional<VideoFrame> JoinedReader::at(std::int64_t stamp_ns) {
    if (const std::size_t part = part_of(stamp_ns); part != opened_) open(part);
    auto frame = reader_->at(stamp_ns - parts_[opened_].offset_ns);
    if (frame) frame->stamp_ns = stamp_ns;
    return frame;
}

// Returns the file that has a frame.
std::size_t JoinedReader::part_of(std::int64_t stamp_ns) const {
    std::size_t part = 0;
    while (part + 1 < parts_.size() && parts_[part + 1].first_ns <= stamp_ns) ++part;
    return part;
}

void JoinedReader::open(std::size_t part) {
    std::vector<std::int64_t> chosen_ns;  // by the file's own times
    for (const std::int64_t stamp_ns : stamps_ns_)
        if (part_of(stamp_ns) == part) chosen_ns.push_back(stamp_ns - parts_[part].offset_ns);
    reader_.emplace(parts_[part].path, chosen_ns, stored_jpeg_);
    opened_ = part;
}

}  // namespace divemesh::video
