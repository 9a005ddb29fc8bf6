#include "worker/pipeline/pair_matcher.hpp"

#include <algorithm>
#include <cstdint>
#include <limits>

#include "worker/base/parallel.hpp"
#include "worker/camera/synchronise_pair.hpp"
#include "worker/features/match_misaligned_stereo.hpp"
#include "worker/pipeline/range_windows.hpp"

namespace divemesh::pipeline {
namespace {

constexpr std::size_t kMaxPairs = 48;
constexpr std::size_t kPairsAtOnce = 12;  // also the min of a longer dive
constexpr std::size_t kMinMatches = 2000;

// Returns i as a fraction with its binary digits reversed: any first few are spread evenly over
// [0, 1) (van der Corput 1935).
double radical_inverse(std::uint32_t i) {
    double value = 0.0;
    for (double digit = 0.5; i > 0; digit *= 0.5, i >>= 1U)
        if (i & 1U) value += digit;
    return value;
}

}  // namespace

std::vector<int> spread_frames(const FrameSpan& span) {
    const auto num = std::min<std::size_t>(kMaxPairs, static_cast<std::size_t>(span.num));
    std::vector<int> frames;
    for (std::uint32_t i = 0; frames.size() < num; ++i) {
        const int frame = span.first + static_cast<int>(radical_inverse(i) * span.num);
        if (std::ranges::find(frames, frame) == frames.end()) frames.push_back(frame);
    }
    return frames;
}

PairMatcher::PairMatcher(const types::Recording& recording,
                         const types::Rig& stated,
                         const types::Rig& rig,
                         int num_threads)
    : recording_(recording),
      num_threads_(num_threads),
      rectifier_(rig, recording.fixed_pattern(), num_threads),
      lenses_(camera::rectified_lenses(rig)),
      stated_rectified_(camera::rectified_rig(stated, recording.fixed_pattern())),
      stated_lenses_(camera::rectified_lenses(stated)) {}

types::StereoMatches PairMatcher::matches(int frame_index) const {
    const auto frame = recording_.frame(frame_index);
    if (!frame) return {};
    types::StereoMatches found = features::match_misaligned_stereo(camera::synchronise_pair(
        rectifier_.rectify(*frame), exposure_motion_at(recording_, rectifier_, *frame)));
    for (types::StereoMatch& match : found) {
        match.left_px = as_stated(0, match.left_px);
        match.right_px = as_stated(1, match.right_px);
    }
    return found;
}

types::StereoMatches PairMatcher::spread_matches(const FrameSpan& span,
                                                 const base::ProgressCallback& progress) const {
    return spread_matches(span, kMinMatches, progress);
}

types::StereoMatches PairMatcher::many_matches(const FrameSpan& span,
                                               const base::ProgressCallback& progress) const {
    return spread_matches(span, std::numeric_limits<std::size_t>::max(), progress);
}

types::StereoMatches PairMatcher::spread_matches(const FrameSpan& span,
                                                 std::size_t num_wanted,
                                                 const base::ProgressCallback& progress) const {
    const std::vector<int> frames = spread_frames(span);
    types::StereoMatches all;
    for (std::size_t begin = 0; begin < frames.size() && all.size() < num_wanted;
         begin += kPairsAtOnce) {
        progress({});
        std::vector<types::StereoMatches> found(std::min(kPairsAtOnce, frames.size() - begin));
        base::for_each_index(num_threads_, found.size(), [&](std::size_t i) {
            found[i] = matches(frames[begin + i]);
        });
        for (const types::StereoMatches& of_pair : found)
            all.insert(all.end(), of_pair.begin(), of_pair.end());
    }
    return all;
}

Eigen::Vector2d PairMatcher::as_stated(std::size_t side, const Eigen::Vector2d& pixel) const {
    return stated_lenses_[side].rectified_px(stated_rectified_,
                                             lenses_[side].recorded_px(rectifier_.rig(), pixel));
}

}  // namespace divemesh::pipeline
