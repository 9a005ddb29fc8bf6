#include "worker/metrics/pieces.hpp"

#include <algorithm>

namespace divemesh::worker {
namespace {

// Of every frame.
std::vector<std::size_t> piece_numbers(const Trajectory& trajectory,
                                       const std::vector<Keyframe>& keyframes) {
    std::vector<std::size_t> numbers;
    std::size_t k = 0;
    for (const StampedPose& pose : trajectory) {
        while (k + 1 < keyframes.size() && keyframes[k + 1].timestamp_ns <= pose.timestamp_ns) ++k;
        numbers.push_back(keyframes.empty() ? 0 : static_cast<std::size_t>(keyframes[k].piece));
    }
    return numbers;
}

double distance_m(const StampedPose& a, const StampedPose& b) {
    return (a.T_world_imu.translation() - b.T_world_imu.translation()).norm();
}

}  // namespace

std::vector<Piece> pieces_of(const Trajectory& trajectory, const std::vector<Keyframe>& keyframes) {
    const std::vector<std::size_t> numbers = piece_numbers(trajectory, keyframes);
    std::vector<Piece> pieces;
    for (std::size_t i = 0; i < trajectory.size(); ++i) {
        if (numbers[i] >= pieces.size()) pieces.resize(numbers[i] + 1);
        Piece& piece = pieces[numbers[i]];
        ++piece.num_frames;
        if (i == 0 || numbers[i - 1] != numbers[i])
            piece.intervals.push_back({trajectory[i].timestamp_ns, 0});
        else
            piece.path_length_m += distance_m(trajectory[i - 1], trajectory[i]);
        piece.intervals.back().last_ns = trajectory[i].timestamp_ns;
    }
    for (const Keyframe& keyframe : keyframes) {
        const auto number = static_cast<std::size_t>(keyframe.piece);
        if (number < pieces.size()) ++pieces[number].num_keyframes;
    }
    return pieces;
}

Trajectory largest_piece(const Trajectory& trajectory, const std::vector<Keyframe>& keyframes) {
    const std::vector<Piece> pieces = pieces_of(trajectory, keyframes);
    const auto largest =
        std::max_element(pieces.begin(), pieces.end(), [](const Piece& a, const Piece& b) {
            return a.num_frames < b.num_frames;
        });
    const auto wanted = static_cast<std::size_t>(largest - pieces.begin());
    const std::vector<std::size_t> numbers = piece_numbers(trajectory, keyframes);
    Trajectory result;
    for (std::size_t i = 0; i < trajectory.size(); ++i)
        if (numbers[i] == wanted) result.push_back(trajectory[i]);
    return result;
}

}  // namespace divemesh::worker
