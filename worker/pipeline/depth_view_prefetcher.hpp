#pragma once

#include <array>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "worker/base/background_task.hpp"
#include "worker/fusion/depth_view.hpp"
#include "worker/fusion/unshared_depth.hpp"
#include "worker/keyframes/keyframe_store.hpp"
#include "worker/types/keyframe.hpp"

namespace divemesh::pipeline {

// A prefetcher that reads frames from the store and prepares them for fusion, in order. The next
// ones are read while the caller works on the current one.
class DepthViewPrefetcher {
public:
    // Returns the voxel for surface at a depth, m; must be thread-safe.
    using VoxelAt = std::function<double(double depth_m)>;

    // Improves the depth of the frame at a place in `frames`; must be thread-safe.
    using Improve = std::function<void(std::size_t frame, types::KeyframeImages& images)>;

    // `frames` and `store` must outlive it.
    DepthViewPrefetcher(const types::RectifiedRig& rig,
                        VoxelAt voxel_at,
                        const std::vector<types::Keyframe>& frames,
                        const keyframes::KeyframeStore& store,
                        Improve improve,
                        base::TaskPool& task_pool);

    // Returns the next frame's view; null at the end. Rethrows errors of reading.
    std::shared_ptr<const fusion::DepthView> next();

private:
    // Reading takes about as long as fusing: two frames are being read or waiting while the caller
    // fuses.
    static constexpr std::size_t kNumLanes = 3;
    static constexpr std::size_t kNeighbours = 2;  // on either side, of frames that may confirm
    struct Lane {
        explicit Lane(base::TaskPool& task_pool) : task(task_pool) {}
        std::shared_ptr<const fusion::DepthView> view;
        base::BackgroundTask task;  // declared last, so that it ends before its target is destroyed
    };
    void fetch(Lane& lane);
    std::vector<fusion::OtherFrame> neighbours_of(std::size_t frame) const;

    const types::RectifiedRig rig_;
    const VoxelAt voxel_at_;
    const std::vector<types::Keyframe>& frames_;
    const keyframes::KeyframeStore& store_;
    const Improve improve_;
    std::array<std::optional<Lane>, kNumLanes> lanes_;
    std::size_t num_fetched_ = 0;
    std::size_t num_taken_ = 0;
};

}  // namespace divemesh::pipeline
