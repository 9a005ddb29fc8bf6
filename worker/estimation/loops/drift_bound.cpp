#include "worker/estimation/loops/drift_bound.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace divemesh::worker {
namespace {

constexpr double kShareOfPath = 0.01;
constexpr double kLeastPosition_m = 0.02;
constexpr double kBlindSpeed_m_s = 0.3;  // that a diver changes to unseen
constexpr double kLeastOrientation_rad = 0.01;
constexpr double kTurn_rad_per_m = 0.002;
constexpr double kBlindTurn_rad_s = 0.05;
constexpr double kNumSigmas = 3.5;
constexpr int kFewestShared = 6;  // landmarks that tie a keyframe to those before

double distance_m(const Keyframe& a, const Keyframe& b) {
    return (a.T_world_cam.translation() - b.T_world_cam.translation()).norm();
}

}  // namespace

DriftBound::DriftBound(const std::vector<Keyframe>& keyframes,
                       const std::vector<Landmark>& landmarks)
    : path_m_(keyframes.size(), 0.0),
      blind_s_(keyframes.size(), 0.0),
      piece_(keyframes.size(), 0),
      first_tied_(keyframes.size()) {
    std::iota(first_tied_.begin(), first_tied_.end(), std::size_t{0});
    std::vector<int> num_passing(keyframes.size() + 1, 0);  // landmarks known before and after
    for (const Landmark& landmark : landmarks) {
        const auto [first, last] = std::minmax_element(
            landmark.observations.begin(),
            landmark.observations.end(),
            [](const auto& a, const auto& b) { return a.keyframe < b.keyframe; });
        const auto from = static_cast<std::size_t>(first->keyframe);
        ++num_passing[from + 1];
        --num_passing[static_cast<std::size_t>(last->keyframe) + 1];
        for (const LandmarkObservation& seen : landmark.observations) {
            std::size_t& tied = first_tied_[static_cast<std::size_t>(seen.keyframe)];
            tied = std::min(tied, from);
        }
    }
    std::partial_sum(num_passing.begin(), num_passing.end(), num_passing.begin());
    for (std::size_t k = 1; k < keyframes.size(); ++k) {
        const bool blind = num_passing[k] < kFewestShared;
        const double interval_s =
            1e-9 * static_cast<double>(keyframes[k].timestamp_ns - keyframes[k - 1].timestamp_ns);
        path_m_[k] = path_m_[k - 1] + distance_m(keyframes[k - 1], keyframes[k]);
        blind_s_[k] = blind_s_[k - 1] + (blind ? interval_s : 0.0);
        piece_[k] = piece_[k - 1] + (blind ? 1 : 0);
    }
    for (std::size_t k = keyframes.size(); k-- > 0;) first_tied_[k] = first_tied_[first_tied_[k]];
}

double DriftBound::path_m(std::size_t a, std::size_t b) const {
    return std::abs(path_m_[b] - path_m_[a]);
}

double DriftBound::blind_s(std::size_t a, std::size_t b) const {
    return std::abs(blind_s_[b] - blind_s_[a]);
}

double DriftBound::position_sigma_m(std::size_t a, std::size_t b) const {
    return std::hypot(kLeastPosition_m, kShareOfPath * path_m(a, b)) +
           kBlindSpeed_m_s * blind_s(a, b);
}

double DriftBound::orientation_sigma_rad(std::size_t a, std::size_t b) const {
    return std::hypot(kLeastOrientation_rad, kTurn_rad_per_m * path_m(a, b)) +
           kBlindTurn_rad_s * blind_s(a, b);
}

bool DriftBound::allows(std::size_t a,
                        std::size_t b,
                        const Eigen::Isometry3d& T_a_b,
                        const Eigen::Isometry3d& expected,
                        double measured_sigma_m) const {
    const double moved_m = (T_a_b.translation() - expected.translation()).norm();
    const double turned_rad =
        Eigen::AngleAxisd(T_a_b.linear().transpose() * expected.linear()).angle();
    return moved_m < kNumSigmas * std::hypot(position_sigma_m(a, b), measured_sigma_m) &&
           turned_rad < kNumSigmas * orientation_sigma_rad(a, b);
}

}  // namespace divemesh::worker
