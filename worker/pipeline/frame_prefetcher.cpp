#include "worker/pipeline/frame_prefetcher.hpp"

#include <utility>

namespace divemesh::pipeline {

FramePrefetcher::FramePrefetcher(types::Recording& recording,
                                 const camera::Rectifier& rectifier,
                                 base::TaskPool& task_pool)
    : recording_(recording), rectifier_(rectifier), task_(task_pool) {
    recording_.rewind();
    fetch();
}

std::optional<types::RectifiedFrame> FramePrefetcher::next() {
    task_.wait();
    auto frame = std::exchange(fetched_, std::nullopt);
    if (frame) fetch();
    return frame;
}

void FramePrefetcher::fetch() {
    task_.run([this] {
        if (const auto recorded = recording_.next_frame()) fetched_ = rectifier_.rectify(*recorded);
    });
}

}  // namespace divemesh::pipeline
