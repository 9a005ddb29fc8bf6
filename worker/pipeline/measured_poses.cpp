#include "worker/pipeline/measured_poses.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <unordered_set>
#include <utility>

namespace divemesh::pipeline {
namespace {

using types::MotionSource;

constexpr std::int64_t kMaxBridge_ns = 1'000'000'000;

std::unordered_set<std::int64_t> timestamps_of(const std::vector<types::Keyframe>& keyframes) {
    std::unordered_set<std::int64_t> result;
    for (const types::Keyframe& keyframe : keyframes) result.insert(keyframe.timestamp_ns);
    return result;
}

// Removes the frames whose timestamp is not among `kept`.
void keep_only(const std::unordered_set<std::int64_t>& kept, std::vector<types::Keyframe>& frames) {
    std::erase_if(frames,
                  [&](const types::Keyframe& frame) { return !kept.contains(frame.timestamp_ns); });
}

// Returns the timestamps of the measured frames.
std::unordered_set<std::int64_t> measured_timestamps(const types::Trajectory& frames,
                                                     const std::vector<bool>& measured) {
    std::unordered_set<std::int64_t> result;
    for (std::size_t i = 0; i < frames.size(); ++i)
        if (measured[i]) result.insert(frames[i].timestamp_ns);
    return result;
}

// Removes the observations from keyframes that are dropped; the others get their new numbers.
void renumber_observations(const std::vector<std::int32_t>& new_numbers,
                           std::vector<types::Landmark>& landmarks) {
    for (types::Landmark& landmark : landmarks) {
        std::erase_if(landmark.observations, [&](const types::LandmarkObservation& seen) {
            return new_numbers[static_cast<std::size_t>(seen.keyframe)] < 0;
        });
        for (types::LandmarkObservation& seen : landmark.observations)
            seen.keyframe = new_numbers[static_cast<std::size_t>(seen.keyframe)];
    }
    std::erase_if(landmarks,
                  [](const types::Landmark& landmark) { return landmark.observations.empty(); });
}

}  // namespace

void bridge_by_imu(const imu::InertialPrior& inertial, types::Track& track) {
    std::vector<MotionSource>& motions = track.motions;
    for (std::size_t first = 1; first < motions.size(); ++first) {
        if (motions[first] == MotionSource::Vision) continue;
        const auto begin = motions.begin() + static_cast<std::ptrdiff_t>(first);
        const auto end = std::find(begin, motions.end(), MotionSource::Vision);
        const auto after = static_cast<std::size_t>(end - motions.begin());
        const std::int64_t from_ns = track.odometry[first - 1].timestamp_ns;
        const std::int64_t to_ns = track.odometry[after - 1].timestamp_ns;
        const bool bridged = first > 1 && end != motions.end() &&
                             std::count(begin, end, MotionSource::Imu) == end - begin &&
                             to_ns - from_ns <= kMaxBridge_ns && inertial.motion(from_ns, to_ns);
        if (!bridged) std::fill(begin, end, MotionSource::Nothing);
        first = after;
    }
}

types::Breaks breaks_of(const types::Track& track) {
    types::Breaks breaks_ns;
    for (std::size_t i = 1; i < track.motions.size(); ++i)
        if (track.motions[i] == MotionSource::Nothing)
            breaks_ns.push_back(track.odometry[i].timestamp_ns);
    return breaks_ns;
}

std::vector<bool> measured_frames(const types::Trajectory& frames,
                                  const types::Breaks& breaks_ns,
                                  const std::vector<types::Keyframe>& keyframes) {
    std::vector<bool> measured(frames.size(), false);
    if (frames.size() == 1) measured[0] = true;
    const std::unordered_set<std::int64_t> kept = timestamps_of(keyframes);
    for (std::size_t begin = 0, end = 0; begin < frames.size(); begin = end) {
        bool has_keyframe = kept.contains(frames[begin].timestamp_ns);
        for (end = begin + 1;
             end < frames.size() && !types::is_break(breaks_ns, frames[end].timestamp_ns);
             ++end)
            has_keyframe = has_keyframe || kept.contains(frames[end].timestamp_ns);
        if (has_keyframe && end - begin > 1)
            std::fill(measured.begin() + static_cast<std::ptrdiff_t>(begin),
                      measured.begin() + static_cast<std::ptrdiff_t>(end),
                      true);
    }
    return measured;
}

types::Trajectory measured_causal(const types::Track& track) {
    const std::vector<bool> measured =
        measured_frames(track.causal, track.breaks_ns, track.keyframes);
    types::Trajectory result;
    for (std::size_t i = 0; i < track.causal.size(); ++i)
        if (measured[i]) result.push_back(track.causal[i]);
    return result;
}

void drop_unmeasured_keyframes(types::Track& track) {
    const auto kept = measured_timestamps(
        track.odometry, measured_frames(track.odometry, track.breaks_ns, track.keyframes));
    std::vector<std::int32_t> new_numbers;
    std::int32_t num_kept = 0;
    for (const types::Keyframe& keyframe : track.keyframes)
        new_numbers.push_back(kept.contains(keyframe.timestamp_ns) ? num_kept++ : -1);
    if (num_kept == std::ssize(track.keyframes)) return;
    renumber_observations(new_numbers, track.landmarks);
    keep_only(kept, track.keyframes);
    keep_only(kept, track.mapped);
}

void set_predicted_apart(types::OptimisedTrack& result) {
    const std::vector<bool> measured =
        measured_frames(result.trajectory, result.breaks_ns, result.keyframes);
    if (std::find(measured.begin(), measured.end(), false) == measured.end()) return;
    const types::Trajectory all = std::exchange(result.trajectory, {});
    const auto covariances = std::exchange(result.covariances, {});
    for (std::size_t i = 0; i < all.size(); ++i) {
        (measured[i] ? result.trajectory : result.predicted).push_back(all[i]);
        if (measured[i] && !covariances.empty()) result.covariances.push_back(covariances[i]);
    }
    keep_only(measured_timestamps(all, measured), result.mapped);
}

}  // namespace divemesh::pipeline
