#include "worker/pipeline/neighbour_frames.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace divemesh::pipeline {
namespace {

constexpr std::size_t kReach = 12;  // frames to either side
constexpr std::size_t kPerSide = 2;
constexpr double kMinBaseline = 0.02;  // of the depth
constexpr double kBaseline = 0.1;
constexpr double kMaxBaseline = 0.4;
constexpr double kMinApart = 0.04;  // of the depth
constexpr double kMinTurn_rad = 0.09;
constexpr double kMinCosine = 0.9;  // between the directions of view

struct Candidate {
    double distance;  // of its baseline from the best one, in powers of e
    std::size_t frame;
};

void add(const std::vector<types::Keyframe>& frames,
         std::size_t frame,
         std::size_t other,
         double depth_m,
         std::vector<Candidate>& candidates) {
    if (frames[other].segment != frames[frame].segment) return;
    const Eigen::Isometry3d T_other_cam =
        frames[other].T_world_cam.inverse() * frames[frame].T_world_cam;
    const double baseline = T_other_cam.translation().norm() / depth_m;
    if (baseline < kMinBaseline || baseline > kMaxBaseline) return;
    if (T_other_cam.linear()(2, 2) < kMinCosine) return;
    candidates.push_back({std::abs(std::log(baseline / kBaseline)), other});
}

void take_best(std::vector<Candidate> candidates, std::vector<std::size_t>& taken) {
    std::sort(candidates.begin(), candidates.end(), [](const Candidate& a, const Candidate& b) {
        return std::pair(a.distance, a.frame) < std::pair(b.distance, b.frame);
    });
    for (std::size_t i = 0; i < std::min(kPerSide, candidates.size()); ++i)
        taken.push_back(candidates[i].frame);
}

}  // namespace

std::vector<std::size_t> neighbour_frames(const std::vector<types::Keyframe>& frames,
                                          std::size_t frame,
                                          double depth_m) {
    std::vector<Candidate> before, after;
    for (std::size_t other = frame - std::min(frame, kReach); other < frame; ++other)
        add(frames, frame, other, depth_m, before);
    for (std::size_t other = frame + 1; other < std::min(frames.size(), frame + kReach + 1);
         ++other)
        add(frames, frame, other, depth_m, after);
    std::vector<std::size_t> taken;
    take_best(std::move(before), taken);
    take_best(std::move(after), taken);
    return taken;
}

std::vector<std::size_t> frames_apart(const std::vector<types::Keyframe>& frames, double depth_m) {
    std::vector<std::size_t> apart;
    for (std::size_t frame = 0; frame < frames.size(); ++frame) {
        if (!apart.empty()) {
            const Eigen::Isometry3d motion =
                frames[apart.back()].T_world_cam.inverse() * frames[frame].T_world_cam;
            const bool is_near = motion.translation().norm() < kMinApart * depth_m;
            const bool is_turned = Eigen::AngleAxisd(motion.linear()).angle() >= kMinTurn_rad;
            if (is_near && !is_turned && frames[apart.back()].segment == frames[frame].segment)
                continue;
        }
        apart.push_back(frame);
    }
    return apart;
}

}  // namespace divemesh::pipeline
