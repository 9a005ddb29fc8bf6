#pragma once

#include <array>
#include <memory>
#include <optional>
#include <vector>

#include "worker/base/background_task.hpp"
#include "worker/fusion/depth_view.hpp"
#include "worker/keyframes/keyframe_store.hpp"
#include "worker/types/keyframe.hpp"

namespace divemesh::pipeline {

// What the store holds of some frames, made ready for fusion, in order; the next ones are read
// while the caller works on this one.
class DepthViewPrefetcher {
public:
    // `frames` and `store` must outlive it.
    DepthViewPrefetcher(const types::RectifiedRig& rig,
                        double voxel_m,
                        const std::vector<types::Keyframe>& frames,
                        const keyframes::KeyframeStore& store,
                        base::TaskPool& task_pool);

    // Null at the end. Throws what reading throws.
    std::shared_ptr<const fusion::DepthView> next();

private:
    // Reading takes about as long as fusing: two are at work or wait while the caller fuses.
    static constexpr std::size_t kNumLanes = 3;
    struct Lane {
        explicit Lane(base::TaskPool& task_pool) : task(task_pool) {}
        std::shared_ptr<const fusion::DepthView> view;
        base::BackgroundTask task;  // ends before what it writes to goes
    };
    void fetch(Lane& lane);

    const types::RectifiedRig rig_;
    const double voxel_m_;
    const std::vector<types::Keyframe>& frames_;
    const keyframes::KeyframeStore& store_;
    std::array<std::optional<Lane>, kNumLanes> lanes_;
    std::size_t num_fetched_ = 0;
    std::size_t num_taken_ = 0;
};

}  // namespace divemesh::pipeline
