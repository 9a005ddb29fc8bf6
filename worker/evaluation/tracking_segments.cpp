#include "worker/evaluation/tracking_segments.hpp"

#include <algorithm>

namespace divemesh::evaluation {
namespace {

// Returns the segment number of every frame.
std::vector<std::size_t> segment_numbers(const types::Trajectory& trajectory,
                                         const std::vector<types::Keyframe>& keyframes) {
    std::vector<std::size_t> numbers;
    std::size_t k = 0;
    for (const types::StampedPose& pose : trajectory) {
        while (k + 1 < keyframes.size() && keyframes[k + 1].timestamp_ns <= pose.timestamp_ns) ++k;
        numbers.push_back(keyframes.empty() ? 0 : static_cast<std::size_t>(keyframes[k].segment));
    }
    return numbers;
}

double distance_m(const types::StampedPose& a, const types::StampedPose& b) {
    return (a.T_world_imu.translation() - b.T_world_imu.translation()).norm();
}

}  // namespace

std::vector<TrackingSegment> segments_of(const types::Trajectory& trajectory,
                                         const std::vector<types::Keyframe>& keyframes) {
    const std::vector<std::size_t> numbers = segment_numbers(trajectory, keyframes);
    std::vector<TrackingSegment> segments;
    for (std::size_t i = 0; i < trajectory.size(); ++i) {
        if (numbers[i] >= segments.size()) segments.resize(numbers[i] + 1);
        TrackingSegment& segment = segments[numbers[i]];
        ++segment.num_frames;
        if (i == 0 || numbers[i - 1] != numbers[i])
            segment.intervals.push_back({trajectory[i].timestamp_ns, 0});
        else
            segment.path_length_m += distance_m(trajectory[i - 1], trajectory[i]);
        segment.intervals.back().last_ns = trajectory[i].timestamp_ns;
    }
    for (const types::Keyframe& keyframe : keyframes) {
        const auto number = static_cast<std::size_t>(keyframe.segment);
        if (number < segments.size()) ++segments[number].num_keyframes;
    }
    return segments;
}

types::Trajectory largest_segment(const types::Trajectory& trajectory,
                                  const std::vector<types::Keyframe>& keyframes) {
    const std::vector<TrackingSegment> segments = segments_of(trajectory, keyframes);
    const auto largest = std::max_element(
        segments.begin(), segments.end(), [](const TrackingSegment& a, const TrackingSegment& b) {
            return a.num_frames < b.num_frames;
        });
    const auto wanted = static_cast<std::size_t>(largest - segments.begin());
    const std::vector<std::size_t> numbers = segment_numbers(trajectory, keyframes);
    types::Trajectory result;
    for (std::size_t i = 0; i < trajectory.size(); ++i)
        if (numbers[i] == wanted) result.push_back(trajectory[i]);
    return result;
}

}  // namespace divemesh::evaluation
