#include "worker/loops/find_loops.hpp"

#include <algorithm>
#include <deque>
#include <optional>

#include "worker/base/rotation_vector.hpp"
#include "worker/loops/consistent_loops.hpp"
#include "worker/loops/find_candidates.hpp"
#include "worker/loops/loop_verifier.hpp"

namespace divemesh::loops {
namespace {

// Keyframes around the last match to which a loop may grow.
constexpr std::size_t kReach = 8;
constexpr double kMaxRotation_rad = 0.7;  // between the keyframes of a grown loop
constexpr int kMaxHalvings = 3;
constexpr double kAligned_px = 4.0;  // error from which patches converge
constexpr double kMaxShift = 0.6;    // in median depths
// Max number of loops to search for, evenly over the dive. Each loads two images, and more loops
// soon repeat the same information.
constexpr std::size_t kMaxLoops = 400;

// The search for loops by geometry alone: at most one per keyframe, and in a long dive one per
// several neighbours.
class LoopSearch {
public:
    LoopSearch(const types::Track& track,
               const keyframes::KeyframeStore& store,
               const DriftModel& drift)
        : track_(track),
          drift_(drift),
          verifier_(track.rig, track.keyframes, track.landmarks, store),
          spacing_(1 + track.keyframes.size() / (kMaxLoops + 1)),
          loop_of_(track.keyframes.size()) {}

    // Returns true if the keyframe or a near neighbour has a loop.
    bool is_covisible(std::size_t keyframe) const {
        const std::size_t end = std::min(keyframe + spacing_, loop_of_.size());
        for (std::size_t i = keyframe + 1 - std::min(keyframe + 1, spacing_); i < end; ++i)
            if (loop_of_[i]) return true;
        return false;
    }

    // Searches for a loop where the track passes within some pixels of an earlier part of itself,
    // so that no recognition is needed. Returns false if there is no earlier keyframe to compare.
    bool expect(std::size_t keyframe) {
        const Eigen::Isometry3d& T_world_cam = track_.keyframes[keyframe].T_world_cam;
        const auto near = nearest(T_world_cam, 0, drift_.first_covisible(keyframe));
        if (!near) return false;
        auto seedling = measure(*near, keyframe, T_world_cam, num_halvings(*near, keyframe));
        if (seedling) grow(std::move(*seedling));
        return true;
    }

    void verify(const LoopCandidate& candidate, std::uint64_t seed) {
        auto seedling = verifier_.verify(candidate.from, candidate.to, seed);
        if (seedling) grow(std::move(*seedling));
    }

    std::vector<Loop> take() {
        std::vector<Loop> loops;
        for (auto& loop : loop_of_)
            if (loop) loops.push_back(std::move(*loop));
        return loops;
    }

private:
    void grow(Loop seedling) {
        std::deque<std::size_t> edge = {seedling.to};
        loop_of_[seedling.to] = std::move(seedling);
        while (!edge.empty()) {
            const Loop& known = *loop_of_[edge.front()];
            edge.pop_front();
            for (const std::size_t next : {known.to + spacing_, known.to - spacing_}) {
                if (next >= loop_of_.size() || is_covisible(next)) continue;
                auto loop = measure_next(known, next);
                if (!loop) continue;
                edge.push_back(next);
                loop_of_[next] = std::move(*loop);
            }
        }
    }

    // Measures the neighbour of a loop's later keyframe, from the pose predicted by the loop.
    std::optional<Loop> measure_next(const Loop& known, std::size_t next) {
        const Eigen::Isometry3d T_world_next =
            track_.keyframes[known.from].T_world_cam * known.T_from_to * between(known.to, next);
        const std::size_t reach = kReach + spacing_ - 1;
        const auto near = nearest(T_world_next,
                                  known.from > reach ? known.from - reach : 0,
                                  std::min(known.from + reach + 1, drift_.first_covisible(next)));
        return near ? measure(*near, next, T_world_next, 0) : std::nullopt;
    }

    // Returns the keyframe from `low` up to `high` whose view is nearest to that of `T_world_cam`;
    // nullopt if no view is near.
    std::optional<std::size_t> nearest(const Eigen::Isometry3d& T_world_cam,
                                       std::size_t low,
                                       std::size_t high) const {
        std::optional<std::size_t> best;
        double min_distance = kMaxShift;
        for (std::size_t i = low; i < high; ++i) {
            const Eigen::Isometry3d& T_world_i = track_.keyframes[i].T_world_cam;
            const double shift = (T_world_i.translation() - T_world_cam.translation()).norm() /
                                 track_.statistics.median_depth_m;
            if (shift >= min_distance) continue;
            const double rotation_rad =
                base::angle_rad(T_world_cam.linear().transpose() * T_world_i.linear());
            if (rotation_rad > kMaxRotation_rad || shift + 0.5 * rotation_rad >= min_distance)
                continue;
            min_distance = shift + 0.5 * rotation_rad;
            best = i;
        }
        return best;
    }

    // Measures `to` relative to `from`, starting at the pose `T_world_to`.
    std::optional<Loop> measure(std::size_t from,
                                std::size_t to,
                                const Eigen::Isometry3d& T_world_to,
                                int num_halvings) {
        return verifier_.measure(
            from, to, T_world_to.inverse() * track_.keyframes[from].T_world_cam, num_halvings);
    }

    // Returns how often to halve the images until the track's drift is some pixels.
    int num_halvings(std::size_t from, std::size_t to) const {
        const double sigma_px = drift_.position_sigma_m(from, to) * track_.rig.focal_px /
                                track_.statistics.median_depth_m;
        int num = 0;
        while (num < kMaxHalvings && sigma_px > kAligned_px * (1 << num)) ++num;
        return num;
    }

    Eigen::Isometry3d between(std::size_t a, std::size_t b) const {
        return track_.keyframes[a].T_world_cam.inverse() * track_.keyframes[b].T_world_cam;
    }

    const types::Track& track_;
    const DriftModel& drift_;
    LoopVerifier verifier_;
    std::size_t spacing_;                       // between keyframes at which loops are searched for
    std::vector<std::optional<Loop>> loop_of_;  // by the later keyframe
};

Eigen::Isometry3d by_track(const types::Track& track, const Loop& loop) {
    return track.keyframes[loop.from].T_world_cam.inverse() * track.keyframes[loop.to].T_world_cam;
}

// Returns the loops that the track's drift allows.
std::vector<Loop> possible(const types::Track& track,
                           const DriftModel& drift,
                           std::vector<Loop> loops) {
    std::erase_if(loops, [&](const Loop& loop) {
        return !drift.allows(
            loop.from, loop.to, loop.T_from_to, by_track(track, loop), loop.sigma_m);
    });
    return loops;
}

}  // namespace

FoundLoops find_loops(const types::Track& track,
                      const DriftModel& drift,
                      const keyframes::KeyframeStore& store,
                      std::uint64_t seed,
                      const base::ProgressCallback& progress) {
    FoundLoops found;
    LoopSearch search(track, store, drift);
    Progress at;
    for (std::size_t k = 0; k < track.keyframes.size(); ++k) {
        progress(at);
        if (!search.is_covisible(k) && search.expect(k)) ++found.statistics.num_candidates;
    }
    std::vector<bool> untied(track.keyframes.size());
    for (std::size_t k = 0; k < untied.size(); ++k) untied[k] = !search.is_covisible(k);
    const auto candidates = find_candidates(
        track.rig, track.keyframes, StoredKeypoints(store, track.keyframes), drift, untied);
    for (std::size_t i = 0; i < candidates.size(); ++i) {
        at.fraction = 0.5 * static_cast<double>(i) / static_cast<double>(candidates.size());
        progress(at);
        if (search.is_covisible(candidates[i].to)) continue;
        ++found.statistics.num_candidates;
        search.verify(candidates[i], seed * 1'000'003U + i);
    }
    const std::vector<Loop> measured = search.take();
    const std::vector<Loop> loops = possible(track, drift, measured);
    for (const std::size_t i : consistent_loops(loops, track.keyframes, drift)) {
        found.loops.push_back(loops[i]);
        const Eigen::Vector3d correction =
            loops[i].T_from_to.translation() - by_track(track, loops[i]).translation();
        found.statistics.largest_correction_m =
            std::max(found.statistics.largest_correction_m, correction.norm());
    }
    found.statistics.num_matched = static_cast<std::int64_t>(measured.size());
    found.statistics.num_accepted = static_cast<std::int64_t>(found.loops.size());
    return found;
}

}  // namespace divemesh::loops
