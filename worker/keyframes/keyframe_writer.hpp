#pragma once

#include <array>
#include <functional>
#include <optional>

#include "schemas/reconstruction_options.hpp"
#include "worker/base/background_task.hpp"
#include "worker/keyframes/keyframe_store.hpp"
#include "worker/stereo/match_stereo.hpp"
#include "worker/types/feature.hpp"
#include "worker/types/search_outcome.hpp"

namespace divemesh::keyframes {

// A writer of what later stages need of a frame, in background tasks: grey image and keypoints of a
// keyframe for loop closure, image and dense depth for the surface. At most five frames wait or are
// processed.
class KeyframeWriter {
public:
    KeyframeWriter(const ReconstructionOptions& options,
                   const KeyframeStore& store,
                   base::TaskPool& task_pool);

    // The results of tracking in a frame.
    struct Seen {
        std::optional<features::DescribedKeypoints>
            view;                                    // nullopt: not a keyframe for loop closure
        types::Features dynamic;                     // their depth is masked
        types::Features scene;                       // static features
        std::optional<types::DisparityRange> range;  // nullopt: the full range
    };

    // Adds a frame, which waits until go_on() or finish(). If `depth` is empty and a surface is
    // requested, the task matches the frame. Rethrows what an earlier frame's task has thrown.
    void write(const types::RectifiedFrame& frame, const types::DepthMap& depth, const Seen& seen);
    // Starts the waiting frame; `dynamic` are features that the next frame showed to be dynamic in
    // it.
    void go_on(const types::Features& dynamic);
    // Waits until every frame is in the store.
    void finish();
    // Returns the statistics of all matched frames; call it after finish().
    types::SearchStatistics statistics() const;

private:
    struct Waiting {
        types::RectifiedFrame frame;
        types::DepthMap depth;
        Seen seen;
    };
    // Dense matching takes longer than tracking. Several frames are being matched or waiting, so
    // that no core is idle while the caller, when it has to wait, matches a frame itself.
    static constexpr std::size_t kNumLanes = 4;
    struct Lane {
        Lane(const ReconstructionOptions& options, base::TaskPool& task_pool)
            : stereo(options.stereo, options.num_disparities_px, options.stereo_scales),
              task(task_pool) {}
        stereo::StereoMatcher stereo;
        types::SearchStatistics matched;
        // Declared last, so that it ends before the matcher is destroyed.
        base::BackgroundTask task;
    };
    void store(Waiting& waiting, Lane& lane) const;

    bool surface_;
    const KeyframeStore& store_;
    std::optional<Waiting> waiting_;
    std::array<std::optional<Lane>, kNumLanes> lanes_;
    std::size_t next_lane_ = 0;
};

}  // namespace divemesh::keyframes
