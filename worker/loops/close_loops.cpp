#include "worker/loops/close_loops.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "worker/loops/pose_graph.hpp"
#include "worker/loops/separate_segments.hpp"
#include "worker/loops/strongest_loops.hpp"
#include "worker/stats/median.hpp"

namespace divemesh::loops {
namespace {

// With a larger error the bundle adjustment of the whole dive may not converge by itself.
constexpr double kBasin_px = 10.0;
// Max loops whose landmarks are fused. Each couples keyframes far apart in time, and the cost of a
// sparse factorisation of the whole dive grows with the cube of such couplings where laps overlap.
// This many hold the dive together as well as all of them.
constexpr std::size_t kMaxFused = 128;

// Returns the median error of the reobserved landmarks in the worst loop, px.
double worst_error_px(const types::RectifiedRig& rig,
                      const std::vector<Loop>& loops,
                      const std::vector<types::Keyframe>& keyframes,
                      const std::vector<types::Landmark>& landmarks) {
    double worst = 0.0;
    for (const Loop& loop : loops) {
        std::vector<double> errors_px;
        for (const Reobservation& again : loop.reobservations) {
            const auto k = static_cast<std::size_t>(again.seen.keyframe);
            const Eigen::Vector3d p_cam =
                keyframes[k].T_world_cam.inverse() * landmarks[again.landmark].p_world;
            errors_px.push_back(
                p_cam.z() < 0.05
                    ? 1e9
                    : (rig.pixel(p_cam) - Eigen::Vector2d(again.seen.u_px, again.seen.v_px))
                          .norm());
        }
        worst = std::max(worst, stats::upper_median(std::move(errors_px)));
    }
    return worst;
}

// Adds the reobservations to the landmarks; each landmark is observed at most once in a keyframe.
void fuse_landmarks(const std::vector<Loop>& loops,
                    const DriftModel& drift,
                    std::vector<types::Landmark>& landmarks) {
    std::set<std::pair<std::size_t, std::int32_t>> added;
    for (const std::size_t i : strongest_loops(loops, drift, kMaxFused))
        for (const Reobservation& again : loops[i].reobservations)
            if (added.insert({again.landmark, again.seen.keyframe}).second)
                landmarks[again.landmark].observations.push_back(again.seen);
}

}  // namespace

std::optional<types::SolverOutcome> close_loops(const types::RectifiedRig& rig,
                                                const std::vector<Loop>& loops,
                                                const DriftModel& drift,
                                                std::vector<types::Keyframe>& keyframes,
                                                std::vector<types::Landmark>& landmarks) {
    number_segments(drift, loops, keyframes);
    std::optional<types::SolverOutcome> outcome;
    if (worst_error_px(rig, loops, keyframes, landmarks) > kBasin_px)
        outcome = optimise_pose_graph(loops, drift, keyframes, landmarks);
    fuse_landmarks(loops, drift, landmarks);
    return outcome;
}

void add_residuals(const std::vector<Loop>& loops,
                   const std::vector<types::Keyframe>& keyframes,
                   types::LoopStatistics& statistics) {
    if (loops.empty()) return;
    double squares_m2 = 0.0;
    double squares_sigmas = 0.0;
    for (const Loop& loop : loops) {
        const Eigen::Isometry3d T_from_to =
            keyframes[loop.from].T_world_cam.inverse() * keyframes[loop.to].T_world_cam;
        const double missed_m2 =
            (T_from_to.translation() - loop.T_from_to.translation()).squaredNorm();
        squares_m2 += missed_m2;
        squares_sigmas += missed_m2 / (3.0 * loop.sigma_m * loop.sigma_m);
    }
    const auto num = static_cast<double>(loops.size());
    statistics.residual_m = std::sqrt(squares_m2 / num);
    statistics.residual_sigmas = std::sqrt(squares_sigmas / num);
}

}  // namespace divemesh::loops
