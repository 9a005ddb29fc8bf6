#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "worker/video/video_reader.hpp"

namespace divemesh::video {

// Decodes H.264 or H.265 that comes as single access units in Annex B, in messages and not in a
// file. Frames come out when the decoder has them, which may be some units later.
class AccessUnitDecoder {
public:
    // Decodes a unit that shows a frame at `stamp_ns`. The first one chooses the codec: `codec` is
    // "h264", "h265" or "hevc". Returns the frames that are ready; those that lack a part are left
    // out. Throws Error{BadData} for another codec and for bytes that are no unit.
    std::vector<VideoFrame> decode(std::string_view codec,
                                   std::int64_t stamp_ns,
                                   std::string_view unit);
    // Returns the frames that the decoder still has. No unit may follow.
    std::vector<VideoFrame> finish();
    // Returns how many units gave no frame; known after finish().
    std::int64_t num_without_frame() const { return num_units_ - num_frames_; }

private:
    std::vector<VideoFrame> receive();

    CodecHandle codec_;  // nullptr before the first unit
    FrameConverter converter_;
    std::int64_t num_units_ = 0;
    std::int64_t num_frames_ = 0;
};

}  // namespace divemesh::video
