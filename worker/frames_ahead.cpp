#include "worker/frames_ahead.hpp"

#include <utility>

namespace divemesh::worker {

FramesAhead::FramesAhead(Recording& recording, const Rectifier& rectifier, Workers& workers)
    : recording_(recording), rectifier_(rectifier), background_(workers) {
    recording_.rewind();
    fetch();
}

std::optional<RectifiedFrame> FramesAhead::next() {
    background_.wait();
    auto frame = std::exchange(fetched_, std::nullopt);
    if (frame) fetch();
    return frame;
}

void FramesAhead::fetch() {
    background_.run([this] {
        if (const auto recorded = recording_.next_frame()) fetched_ = rectifier_.rectify(*recorded);
    });
}

}  // namespace divemesh::worker
