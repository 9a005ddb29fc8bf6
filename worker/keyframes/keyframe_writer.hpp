#pragma once

#include <array>
#include <functional>
#include <optional>

#include "worker/base/background_task.hpp"
#include "worker/keyframes/keyframe_store.hpp"
#include "worker/stereo/match_stereo.hpp"
#include "worker/types/feature.hpp"
#include "worker/types/search_outcome.hpp"

namespace divemesh::keyframes {

// Puts what later stages will ask for of a frame into the store, beside the caller: the grey
// picture of a keyframe and what it is recognised by, to close loops with; picture and dense depth,
// to make the surface. At most five frames wait or are worked on.
class KeyframeWriter {
public:
    KeyframeWriter(const types::RectifiedRig& rig,
                   const ReconstructionOptions& options,
                   const KeyframeStore& store,
                   base::TaskPool& task_pool);

    // What the tracking saw in a frame.
    struct Seen {
        std::optional<features::DescribedKeypoints>
            view;                 // of a keyframe that loops may be closed with
        types::Features dynamic;  // by themselves: the surface is kept free of them
        types::Features scene;    // that went with the camera's motion
        std::optional<types::DisparityRange> range;  // nothing: the whole one
    };

    // `depth`: empty when the caller had no need of it; it is matched here when a surface is asked
    // for. Throws what the frame before has thrown.
    // The frame waits until go_on() or finish().
    void write(const types::RectifiedFrame& frame, const types::DepthMap& depth, const Seen& seen);
    // The next frame showed that these moved in the one that waits.
    void go_on(const types::Features& dynamic);
    // Every frame is in the store then.
    void finish();
    // Of all frames that were matched; after finish().
    types::SearchStatistics statistics() const;

private:
    struct Waiting {
        types::RectifiedFrame frame;
        types::DepthMap depth;
        Seen seen;
    };
    // Dense matching takes longer than tracking: several frames are at work or wait their turn, so
    // that nobody is idle while the caller, made to wait, matches one itself.
    static constexpr std::size_t kNumLanes = 4;
    struct Lane {
        Lane(const types::RectifiedRig& rig,
             const ReconstructionOptions& options,
             base::TaskPool& task_pool)
            : stereo(rig, options), task(task_pool) {}
        stereo::StereoMatcher stereo;
        types::SearchStatistics matched;
        base::BackgroundTask task;  // ends before the matcher goes
    };
    void store(Waiting& waiting, Lane& lane) const;

    bool surface_;
    const KeyframeStore& store_;
    std::optional<Waiting> waiting_;
    std::array<std::optional<Lane>, kNumLanes> lanes_;
    std::size_t next_lane_ = 0;
};

}  // namespace divemesh::keyframes
