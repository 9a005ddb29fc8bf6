#pragma once

#include <optional>

#include "worker/base/background_task.hpp"
#include "worker/camera/rectifier.hpp"
#include "worker/types/recording.hpp"

namespace divemesh::worker {

// The frames of a recording, rectified; the next one is decoded while the caller works on this one.
// Nobody else may read frames of the recording meanwhile.
class FramePrefetcher {
public:
    // Starts at the first frame.
    FramePrefetcher(Recording& recording, const Rectifier& rectifier, TaskPool& task_pool);

    // Nothing at the end. Throws what decoding throws.
    std::optional<RectifiedFrame> next();

private:
    void fetch();

    Recording& recording_;
    const Rectifier& rectifier_;
    std::optional<RectifiedFrame> fetched_;
    BackgroundTask task_;
};

}  // namespace divemesh::worker
