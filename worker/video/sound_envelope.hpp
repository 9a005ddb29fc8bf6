#pragma once

#include <vector>

#include "worker/base/observer.hpp"
#include "worker/video/indexed_video.hpp"

namespace divemesh::video {

// How loud a video is over time, on the clock of its images.
struct SoundEnvelope {
    static constexpr double kBin_s = 0.25e-3;

    double start_s = 0.0;
    std::vector<float> loudness;  // one for each kBin_s; 0 where there is no sound

    double end_s() const { return start_s + kBin_s * static_cast<double>(loudness.size()); }
};

// Returns the first `max_s` of a video's sound; nothing if it has none that can be decoded. Throws
// as VideoFile does.
SoundEnvelope read_sound(const std::vector<VideoPart>& parts,
                         double max_s,
                         const base::ProgressCallback& progress);

}  // namespace divemesh::video
