#pragma once

#include <array>
#include <memory>
#include <optional>
#include <vector>

#include "worker/background.hpp"
#include "worker/keyframe.hpp"
#include "worker/keyframe_store.hpp"
#include "worker/volume/depth_view.hpp"

namespace divemesh::worker {

// What the store holds of some frames, made ready for fusion, in order; the next ones are read
// while the caller works on this one.
class ViewsAhead {
public:
    // `frames` and `store` must outlive it.
    ViewsAhead(const RectifiedRig& rig,
               double voxel_m,
               const std::vector<Keyframe>& frames,
               const KeyframeStore& store,
               Workers& workers);

    // Null at the end. Throws what reading throws.
    std::shared_ptr<const DepthView> next();

private:
    // Reading takes about as long as fusing: two are at work or wait while the caller fuses.
    static constexpr std::size_t kNumLanes = 3;
    struct Lane {
        explicit Lane(Workers& workers) : background(workers) {}
        std::shared_ptr<const DepthView> view;
        Background background;  // ends before what it writes to goes
    };
    void fetch(Lane& lane);

    const RectifiedRig rig_;
    const double voxel_m_;
    const std::vector<Keyframe>& frames_;
    const KeyframeStore& store_;
    std::array<std::optional<Lane>, kNumLanes> lanes_;
    std::size_t num_fetched_ = 0;
    std::size_t num_taken_ = 0;
};

}  // namespace divemesh::worker
