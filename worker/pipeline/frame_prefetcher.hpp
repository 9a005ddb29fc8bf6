#pragma once

#include <optional>

#include "worker/base/background_task.hpp"
#include "worker/camera/rectifier.hpp"
#include "worker/types/recording.hpp"

namespace divemesh::pipeline {

// A prefetcher that reads and rectifies the frames of a recording. The next one is decoded while
// the caller works on the current one. Meanwhile no other code may read frames of the recording.
class FramePrefetcher {
public:
    // Starts at the first frame.
    FramePrefetcher(types::Recording& recording,
                    const camera::Rectifier& rectifier,
                    base::TaskPool& task_pool);

    // Returns the next frame; nullopt at the end. Rethrows errors of decoding.
    std::optional<types::RectifiedFrame> next();

private:
    void fetch();

    types::Recording& recording_;
    const camera::Rectifier& rectifier_;
    std::optional<types::RectifiedFrame> fetched_;
    base::BackgroundTask task_;
};

}  // namespace divemesh::pipeline
