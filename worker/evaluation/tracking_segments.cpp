#include "worker/evaluation/tracking_segments.hpp"

#include <algorithm>
#include <optional>

namespace divemesh::evaluation {
namespace {

// Gives the frames from the last break before a keyframe on to the segment of that keyframe.
void move_to_next(const types::Trajectory& trajectory,
                  const std::vector<types::Keyframe>& keyframes,
                  const types::Breaks& breaks_ns,
                  std::vector<std::size_t>& numbers) {
    std::size_t i = 0;
    for (std::size_t k = 1; k < keyframes.size(); ++k) {
        std::optional<std::size_t> last_break;
        for (; i < trajectory.size() && trajectory[i].timestamp_ns < keyframes[k].timestamp_ns; ++i)
            if (types::is_break(breaks_ns, trajectory[i].timestamp_ns) &&
                trajectory[i].timestamp_ns > keyframes[k - 1].timestamp_ns)
                last_break = i;
        if (!last_break) continue;
        std::fill(numbers.begin() + static_cast<std::ptrdiff_t>(*last_break),
                  numbers.begin() + static_cast<std::ptrdiff_t>(i),
                  static_cast<std::size_t>(keyframes[k].segment));
    }
}

double distance_m(const types::StampedPose& a, const types::StampedPose& b) {
    return (a.T_world_imu.translation() - b.T_world_imu.translation()).norm();
}

}  // namespace

std::vector<std::size_t> segment_numbers(const types::Trajectory& trajectory,
                                         const std::vector<types::Keyframe>& keyframes,
                                         const types::Breaks& breaks_ns) {
    std::vector<std::size_t> numbers;
    std::size_t k = 0;
    for (const types::StampedPose& pose : trajectory) {
        while (k + 1 < keyframes.size() && keyframes[k + 1].timestamp_ns <= pose.timestamp_ns) ++k;
        numbers.push_back(keyframes.empty() ? 0 : static_cast<std::size_t>(keyframes[k].segment));
    }
    move_to_next(trajectory, keyframes, breaks_ns, numbers);
    return numbers;
}

std::vector<types::TrackingSegment> segments_of(const types::Trajectory& trajectory,
                                                const std::vector<types::Keyframe>& keyframes,
                                                const types::Breaks& breaks_ns) {
    const std::vector<std::size_t> numbers = segment_numbers(trajectory, keyframes, breaks_ns);
    std::vector<types::TrackingSegment> segments;
    for (std::size_t i = 0; i < trajectory.size(); ++i) {
        if (numbers[i] >= segments.size()) segments.resize(numbers[i] + 1);
        types::TrackingSegment& segment = segments[numbers[i]];
        ++segment.num_frames;
        if (i == 0 || numbers[i - 1] != numbers[i])
            segment.intervals.push_back({trajectory[i].timestamp_ns, 0});
        else if (!types::is_break(breaks_ns, trajectory[i].timestamp_ns))
            segment.path_length_m += distance_m(trajectory[i - 1], trajectory[i]);
        segment.intervals.back().last_ns = trajectory[i].timestamp_ns;
    }
    for (const types::Keyframe& keyframe : keyframes) {
        const auto number = static_cast<std::size_t>(keyframe.segment);
        if (number < segments.size()) ++segments[number].num_keyframes;
    }
    return segments;
}

std::size_t number_of_largest(const std::vector<types::TrackingSegment>& segments) {
    const auto largest =
        std::max_element(segments.begin(),
                         segments.end(),
                         [](const types::TrackingSegment& a, const types::TrackingSegment& b) {
                             return a.num_frames < b.num_frames;
                         });
    return static_cast<std::size_t>(largest - segments.begin());
}

types::Trajectory within_largest(const types::Trajectory& trajectory,
                                 const std::vector<types::TrackingSegment>& segments) {
    types::Trajectory result = trajectory;
    if (segments.size() < 2) return result;
    const types::TrackingSegment& largest = segments[number_of_largest(segments)];
    std::erase_if(result, [&](const types::StampedPose& pose) {
        return !largest.contains(pose.timestamp_ns);
    });
    return result;
}

}  // namespace divemesh::evaluation
