#include "worker/estimation/window.hpp"

#include <algorithm>
#include <set>

namespace divemesh::worker {
namespace {

constexpr std::size_t kNumFree = 7;    // keyframes that move
constexpr std::size_t kMostFixed = 8;  // older ones that hold them
constexpr int kMaxIterations = 6;
constexpr double kOutlier = 5.0;                                   // in sigmas, per measurement
constexpr double kFirstBiasSigma = 0.02;                           // rad/s
const Eigen::Vector3d kLandmarkSigma_px = 0.5 * kFeatureSigma_px;  // of an adjusted landmark

Eigen::Vector3d measurement_px(const LandmarkObservation& seen) {
    return {seen.u_px, seen.v_px, seen.disparity_px};
}

bool fits(const RectifiedRig& rig,
          const Eigen::Isometry3d& T_cam_world,
          const Landmark& landmark,
          const LandmarkObservation& seen) {
    const Eigen::Vector3d p_cam = T_cam_world * landmark.p_world;
    if (p_cam.z() < 0.02) return false;
    Eigen::Vector3d error = project_px(rig, p_cam) - measurement_px(seen);
    if (seen.disparity_px <= 0.0F) error.z() = 0.0;
    return error.cwiseQuotient(kFeatureSigma_px).cwiseAbs().maxCoeff() < kOutlier;
}

}  // namespace

void Window::add_keyframe(const Keyframe& keyframe,
                          const Features& features,
                          const std::optional<GyroscopeIntegral>& turn) {
    const auto index = static_cast<std::int32_t>(keyframes_.size());
    Eigen::Vector3d bias = Eigen::Vector3d::Zero();
    if (turn)
        bias = turn->bias;
    else if (!entries_.empty())
        bias = gyroscope_bias();
    Entry& entry = entries_.emplace_back();
    entry.state = BodyState::at(keyframe.T_world_cam * rig_.T_imu_cam.inverse(), bias);
    entry.turn = turn;
    for (const Feature& feature : features) {
        if (!has_depth(feature) && !landmark_of_feature_.contains(feature.id)) continue;
        const std::size_t landmark = landmark_of(feature, keyframe);
        landmarks_[landmark].observations.push_back({index,
                                                     static_cast<float>(feature.pixel.x()),
                                                     static_cast<float>(feature.pixel.y()),
                                                     static_cast<float>(feature.disparity_px)});
        entry.landmarks.push_back(landmark);
    }
    keyframes_.push_back(keyframe);
}

std::size_t Window::landmark_of(const Feature& feature, const Keyframe& keyframe) {
    const auto [known, fresh] = landmark_of_feature_.try_emplace(feature.id, landmarks_.size());
    if (fresh) landmarks_.push_back({keyframe.T_world_cam * point_cam(rig_, feature), {}});
    return known->second;
}

void Window::adjust() {
    const std::size_t num = keyframes_.size();
    const std::size_t first_free = num > kNumFree ? num - kNumFree : 1;
    const std::size_t first = first_free > kMostFixed ? first_free - kMostFixed : 0;
    if (num < 2) return;

    Adjustment adjustment(rig_);
    for (std::size_t k = first; k < num; ++k)
        adjustment.add_state(entries_[k].state, k < first_free);
    add_landmarks(adjustment, first, first_free);
    add_turns(adjustment, first_free);
    adjustment.solve(Adjustment::Size::Window, kMaxIterations, ignore_progress, {});
    for (std::size_t k = first_free; k < num; ++k)
        keyframes_[k].T_world_cam = entries_[k].state.T_world_imu() * rig_.T_imu_cam;
    drop_outliers(first_free);
}

void Window::add_landmarks(Adjustment& adjustment, std::size_t first, std::size_t first_free) {
    std::set<std::size_t> seen_by_free;
    for (std::size_t k = first_free; k < entries_.size(); ++k)
        seen_by_free.insert(entries_[k].landmarks.begin(), entries_[k].landmarks.end());
    for (const std::size_t index : seen_by_free) {
        Landmark& landmark = landmarks_[index];
        if (landmark.observations.size() < 2) continue;
        for (const LandmarkObservation& seen : landmark.observations) {
            const auto k = static_cast<std::size_t>(seen.keyframe);
            if (k < first) continue;
            adjustment.add_observation(
                entries_[k].state, landmark.p_world, measurement_px(seen), kFeatureSigma_px);
        }
    }
}

void Window::add_turns(Adjustment& adjustment, std::size_t first_free) {
    bool held = false;
    for (std::size_t k = first_free; k < entries_.size(); ++k) {
        if (!entries_[k].turn) continue;
        BodyState& from = entries_[k - 1].state;
        adjustment.add_turn(from, entries_[k].state, *entries_[k].turn, gyroscope_random_walk_);
        if (!held && first_free > 1) adjustment.fix_bias(from);
        if (!held && first_free == 1)
            adjustment.add_bias(from, Eigen::Vector3d::Zero(), kFirstBiasSigma);
        held = true;
    }
}

void Window::drop_outliers(std::size_t first_free) {
    std::set<std::size_t> seen_by_free;
    for (std::size_t k = first_free; k < entries_.size(); ++k)
        seen_by_free.insert(entries_[k].landmarks.begin(), entries_[k].landmarks.end());
    for (const std::size_t index : seen_by_free) {
        Landmark& landmark = landmarks_[index];
        std::erase_if(landmark.observations, [&](const LandmarkObservation& seen) {
            const auto k = static_cast<std::size_t>(seen.keyframe);
            if (k < first_free) return false;
            return !fits(rig_, keyframes_[k].T_world_cam.inverse(), landmark, seen);
        });
    }
}

void Window::use_landmarks(const Eigen::Isometry3d& T_world_previous, PointPairs& pairs) const {
    const Eigen::Isometry3d T_previous_world = T_world_previous.inverse();
    for (PointPair& pair : pairs) {
        const auto known = landmark_of_feature_.find(pair.id);
        if (known == landmark_of_feature_.end()) continue;
        const Landmark& landmark = landmarks_[known->second];
        if (landmark.observations.size() < 2) continue;
        const Eigen::Vector3d p_previous = T_previous_world * landmark.p_world;
        if (p_previous.z() < 0.02) continue;
        pair.p_previous = p_previous;
        pair.previous_px = project_px(rig_, p_previous);
        pair.previous_sigma_px = kLandmarkSigma_px;
    }
}

std::vector<Landmark> Window::landmarks() const {
    std::vector<Landmark> result;
    for (const Landmark& landmark : landmarks_)
        if (landmark.observations.size() >= 2) result.push_back(landmark);
    return result;
}

}  // namespace divemesh::worker
