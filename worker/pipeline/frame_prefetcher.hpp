#pragma once

#include <optional>

#include "worker/base/background_task.hpp"
#include "worker/camera/rectifier.hpp"
#include "worker/types/recording.hpp"

namespace divemesh::pipeline {

// The frames of a recording, rectified; the next one is decoded while the caller works on this one.
// Nobody else may read frames of the recording meanwhile.
class FramePrefetcher {
public:
    // Starts at the first frame.
    FramePrefetcher(types::Recording& recording,
                    const camera::Rectifier& rectifier,
                    base::TaskPool& task_pool);

    // Nothing at the end. Throws what decoding throws.
    std::optional<types::RectifiedFrame> next();

private:
    void fetch();

    types::Recording& recording_;
    const camera::Rectifier& rectifier_;
    std::optional<types::RectifiedFrame> fetched_;
    base::BackgroundTask task_;
};

}  // namespace divemesh::pipeline
