#pragma once

#include <array>
#include <vector>

#include "worker/base/observer.hpp"
#include "worker/camera/rectified_lens.hpp"
#include "worker/camera/rectifier.hpp"
#include "worker/types/recording.hpp"
#include "worker/types/stereo_match.hpp"

namespace divemesh::pipeline {

// Frames of a recording that follow each other.
struct FrameSpan {
    int first = 0;
    int num = 0;
};

// Returns up to 48 frames spread over the span, also if only the first few of them are read.
std::vector<int> spread_frames(const FrameSpan& span);

// Matches pairs after rectification with `rig` and returns them as rectified with `stated`.
class PairMatcher {
public:
    PairMatcher(const types::Recording& recording,
                const types::Rig& stated,
                const types::Rig& rig,
                int num_threads);

    // Returns an empty list if the frame cannot be read.
    types::StereoMatches matches(int frame_index) const;
    // Returns those of pairs spread over the span, pair by pair, until there are 2000 or those of
    // 48 pairs.
    types::StereoMatches spread_matches(const FrameSpan& span,
                                        const base::ProgressCallback& progress) const;
    // Returns those of 48 pairs.
    types::StereoMatches many_matches(const FrameSpan& span,
                                      const base::ProgressCallback& progress) const;

private:
    types::StereoMatches spread_matches(const FrameSpan& span,
                                        std::size_t num_wanted,
                                        const base::ProgressCallback& progress) const;
    Eigen::Vector2d as_stated(std::size_t side, const Eigen::Vector2d& pixel) const;

    const types::Recording& recording_;
    int num_threads_;
    camera::Rectifier rectifier_;
    std::array<camera::RectifiedLens, 2> lenses_;
    types::RectifiedRig stated_rectified_;
    std::array<camera::RectifiedLens, 2> stated_lenses_;
};

}  // namespace divemesh::pipeline
