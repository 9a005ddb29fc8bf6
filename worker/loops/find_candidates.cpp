#include "worker/loops/find_candidates.hpp"

#include <algorithm>
#include <cmath>

#include "worker/loops/inverted_index.hpp"
#include "worker/stats/median.hpp"

namespace divemesh::loops {
namespace {

constexpr std::size_t kMaxLoopCandidates = 3;  // per keyframe
constexpr std::size_t kApart = 3;              // keyframes between two candidates
constexpr double kMinSimilarity = 0.02;
constexpr double kMaxRotation_rad = 1.0;  // between the viewing directions
constexpr double kNumSigmas = 3.0;

// The part of the scene that a keyframe shows.
struct Sight {
    Eigen::Vector3d centre_world = Eigen::Vector3d::Zero();
    Eigen::Vector3d axis_world = Eigen::Vector3d::UnitZ();
    double radius_m = 0.0;  // 0: no point has depth
};

Sight sight_of(const types::RectifiedRig& rig,
               const types::Keyframe& keyframe,
               const features::DescribedKeypoints& keypoints) {
    std::vector<float> disparities_px;
    for (const features::DescribedKeypoint& point : keypoints)
        if (point.disparity_px > 0.0F) disparities_px.push_back(point.disparity_px);
    Sight sight;
    if (disparities_px.empty()) return sight;
    const double depth_m = rig.depth_m(stats::upper_median(std::move(disparities_px)));
    sight.centre_world = keyframe.T_world_cam * Eigen::Vector3d(0.0, 0.0, depth_m);
    sight.axis_world = keyframe.T_world_cam.linear().col(2);
    sight.radius_m = depth_m * rig.width_px / (2.0 * rig.focal_px);
    return sight;
}

class Gate {
public:
    Gate(const types::RectifiedRig& rig,
         const std::vector<types::Keyframe>& keyframes,
         const StoredKeypoints& keypoints,
         const DriftModel& drift)
        : drift_(drift) {
        for (std::size_t k = 0; k < keyframes.size(); ++k)
            sights_.push_back(sight_of(rig, keyframes[k], keypoints[k]));
    }

    // Returns true if the two may show the same place.
    bool open(std::size_t a, std::size_t b) const {
        const Sight& one = sights_[a];
        const Sight& other = sights_[b];
        if (one.radius_m <= 0.0 || other.radius_m <= 0.0) return false;
        const double distance_m = (one.centre_world - other.centre_world).norm();
        if (distance_m > one.radius_m + other.radius_m + kNumSigmas * drift_.position_sigma_m(a, b))
            return false;
        const double rotation_rad =
            std::acos(std::clamp(one.axis_world.dot(other.axis_world), -1.0, 1.0));
        return rotation_rad < kMaxRotation_rad + kNumSigmas * drift_.orientation_sigma_rad(a, b);
    }

private:
    const DriftModel& drift_;
    std::vector<Sight> sights_;
};

}  // namespace

std::vector<LoopCandidate> find_candidates(const types::RectifiedRig& rig,
                                           const std::vector<types::Keyframe>& keyframes,
                                           const StoredKeypoints& keypoints,
                                           const DriftModel& drift,
                                           const std::vector<bool>& wanted) {
    const InvertedIndex index(keypoints);
    const Gate gate(rig, keyframes, keypoints, drift);
    std::vector<LoopCandidate> candidates;
    for (std::size_t k = 0; k < keyframes.size(); ++k) {
        if (!wanted[k]) continue;
        const std::vector<float> similarity = index.similarity(k);
        std::vector<std::size_t> possible;
        for (std::size_t i = 0; i < drift.first_covisible(k); ++i)
            if (similarity[i] >= kMinSimilarity && gate.open(i, k)) possible.push_back(i);
        std::stable_sort(possible.begin(), possible.end(), [&](std::size_t a, std::size_t b) {
            return similarity[a] > similarity[b];
        });
        std::vector<std::size_t> chosen;
        for (const std::size_t i : possible) {
            if (chosen.size() == kMaxLoopCandidates) break;
            if (std::all_of(chosen.begin(), chosen.end(), [&](std::size_t other) {
                    return std::max(i, other) - std::min(i, other) > kApart;
                }))
                chosen.push_back(i);
        }
        for (const std::size_t i : chosen) candidates.push_back({i, k});
    }
    return candidates;
}

}  // namespace divemesh::loops
