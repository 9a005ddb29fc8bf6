#include "worker/loops/consistent_loops.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "worker/base/rotation_vector.hpp"
#include "worker/loops/max_clique.hpp"
#include "worker/loops/strongest_loops.hpp"

namespace divemesh::loops {
namespace {

// Searched exactly; other loops must agree with the result.
constexpr std::size_t kMaxInClique = 400;
constexpr std::size_t kMinLoops = 2;
constexpr std::size_t kMinLoopsAcrossGap = 3;

class Consistency {
public:
    Consistency(const std::vector<Loop>& loops,
                const std::vector<types::Keyframe>& keyframes,
                const DriftModel& drift)
        : loops_(loops), keyframes_(keyframes), drift_(drift) {}

    // Returns true if loop i agrees with the path along the track to loop j, over it, and back.
    bool agree(std::size_t i, std::size_t j) const {
        const Loop& a = loops_[i];
        const Loop& b = loops_[j];
        const Eigen::Isometry3d expected =
            between(a.from, b.from) * b.T_from_to * between(b.to, a.to);
        const double moved_m = (a.T_from_to.translation() - expected.translation()).norm();
        const double turned_rad =
            base::angle_rad(a.T_from_to.linear().transpose() * expected.linear());
        const double position_sigma_m =
            std::hypot(std::hypot(drift_.position_sigma_m(a.from, b.from),
                                  drift_.position_sigma_m(a.to, b.to)),
                       std::hypot(a.sigma_m, b.sigma_m));
        const double orientation_sigma_rad = std::hypot(
            drift_.orientation_sigma_rad(a.from, b.from), drift_.orientation_sigma_rad(a.to, b.to));
        return moved_m < kNumSigmas * position_sigma_m &&
               turned_rad < kNumSigmas * orientation_sigma_rad;
    }

private:
    static constexpr double kNumSigmas = 3.0;

    Eigen::Isometry3d between(std::size_t a, std::size_t b) const {
        return keyframes_[a].T_world_cam.inverse() * keyframes_[b].T_world_cam;
    }

    const std::vector<Loop>& loops_;
    const std::vector<types::Keyframe>& keyframes_;
    const DriftModel& drift_;
};

// Drops the loops between parts of the track that too few loops connect.
void drop_weak_joints(const std::vector<Loop>& loops,
                      const DriftModel& drift,
                      std::vector<std::size_t>& chosen) {
    const auto joint = [&](std::size_t i) {
        return std::pair(drift.segment(loops[i].from), drift.segment(loops[i].to));
    };
    std::map<std::pair<std::int32_t, std::int32_t>, std::size_t> strength;
    for (const std::size_t i : chosen) ++strength[joint(i)];
    std::erase_if(chosen, [&](std::size_t i) {
        const auto segments = joint(i);
        return strength[segments] <
               (segments.first == segments.second ? kMinLoops : kMinLoopsAcrossGap);
    });
}

}  // namespace

std::vector<std::size_t> consistent_loops(const std::vector<Loop>& loops,
                                          const std::vector<types::Keyframe>& keyframes,
                                          const DriftModel& drift) {
    if (loops.empty()) return {};
    const Consistency consistency(loops, keyframes, drift);
    const std::vector<std::size_t> searched = strongest_loops(loops, drift, kMaxInClique);
    std::vector<std::vector<bool>> joined(searched.size(),
                                          std::vector<bool>(searched.size(), false));
    for (std::size_t i = 0; i < searched.size(); ++i)
        for (std::size_t j = i + 1; j < searched.size(); ++j)
            joined[i][j] = joined[j][i] = consistency.agree(searched[i], searched[j]);
    std::vector<std::size_t> core;
    for (const std::size_t i : max_clique(joined)) core.push_back(searched[i]);

    std::vector<std::size_t> chosen;
    for (std::size_t i = 0; i < loops.size(); ++i)
        if (std::all_of(core.begin(), core.end(), [&](std::size_t member) {
                return member == i || consistency.agree(i, member);
            }))
            chosen.push_back(i);
    drop_weak_joints(loops, drift, chosen);
    return chosen;
}

}  // namespace divemesh::loops
