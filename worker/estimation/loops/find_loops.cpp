#include "worker/estimation/loops/find_loops.hpp"

#include <algorithm>
#include <deque>
#include <optional>

#include "worker/estimation/loops/consistent_loops.hpp"
#include "worker/estimation/loops/drift_bound.hpp"
#include "worker/estimation/loops/find_candidates.hpp"
#include "worker/estimation/loops/measure_loop.hpp"

namespace divemesh::worker {
namespace {

constexpr std::size_t kReach = 8;      // keyframes about the one before that a loop grows to
constexpr double kMostTurn_rad = 0.7;  // between the views of a loop that is grown
constexpr double kMostShift = 0.6;     // in depths of the view

// Loops by geometry alone, each keyframe's at most one.
class LoopSearch {
public:
    LoopSearch(const Track& track, const KeyframeStore& store, const DriftBound& drift)
        : track_(track),
          drift_(drift),
          meter_(track.rig, track.keyframes, track.landmarks, track.views, store),
          loop_of_(track.keyframes.size()) {}

    bool has_loop(std::size_t keyframe) const { return loop_of_[keyframe].has_value(); }

    void recognise(const LoopCandidate& candidate, std::uint64_t seed) {
        auto seedling = meter_.recognise(candidate.from, candidate.to, seed);
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
            for (const std::size_t next : {known.to + 1, known.to - 1}) {
                if (next >= loop_of_.size() || has_loop(next)) continue;
                auto loop = measure_next(known, next);
                if (!loop) continue;
                edge.push_back(next);
                loop_of_[next] = std::move(*loop);
            }
        }
    }

    // The neighbour of a loop's later keyframe, against the earlier keyframe nearest to it.
    std::optional<Loop> measure_next(const Loop& known, std::size_t next) {
        const Eigen::Isometry3d T_from_next = known.T_from_to * between(known.to, next);
        const std::size_t low = known.from > kReach ? known.from - kReach : 0;
        const std::size_t high = std::min(known.from + kReach + 1, drift_.first_tied(next));
        std::optional<std::size_t> best;
        double least = kMostShift;
        Eigen::Isometry3d T_next_best;
        for (std::size_t i = low; i < high; ++i) {
            const Eigen::Isometry3d T_next_i = T_from_next.inverse() * between(known.from, i);
            const double turn_rad = Eigen::AngleAxisd(T_next_i.linear()).angle();
            const double shift = T_next_i.translation().norm() / track_.statistics.median_depth_m;
            if (turn_rad > kMostTurn_rad || shift + 0.5 * turn_rad >= least) continue;
            least = shift + 0.5 * turn_rad;
            best = i;
            T_next_best = T_next_i;
        }
        if (!best) return std::nullopt;
        return meter_.measure(*best, next, T_next_best);
    }

    Eigen::Isometry3d between(std::size_t a, std::size_t b) const {
        return track_.keyframes[a].T_world_cam.inverse() * track_.keyframes[b].T_world_cam;
    }

    const Track& track_;
    const DriftBound& drift_;
    LoopMeter meter_;
    std::vector<std::optional<Loop>> loop_of_;  // by the later keyframe
};

Eigen::Isometry3d by_track(const Track& track, const Loop& loop) {
    return track.keyframes[loop.from].T_world_cam.inverse() * track.keyframes[loop.to].T_world_cam;
}

// What the track's drift does not forbid.
std::vector<Loop> possible(const Track& track, const DriftBound& drift, std::vector<Loop> loops) {
    std::erase_if(loops, [&](const Loop& loop) {
        return !drift.allows(
            loop.from, loop.to, loop.T_from_to, by_track(track, loop), loop.sigma_m);
    });
    return loops;
}

}  // namespace

FoundLoops find_loops(const Track& track,
                      const KeyframeStore& store,
                      std::uint64_t seed,
                      const ProgressCallback& progress) {
    const DriftBound drift(track.keyframes, track.landmarks);
    const auto candidates = find_candidates(track.rig, track.keyframes, track.views, drift);
    LoopSearch search(track, store, drift);
    FoundLoops found;
    Progress at;
    for (std::size_t i = 0; i < candidates.size(); ++i) {
        at.fraction = 0.5 * static_cast<double>(i) / static_cast<double>(candidates.size());
        progress(at);
        if (search.has_loop(candidates[i].to)) continue;
        ++found.statistics.num_candidates;
        search.recognise(candidates[i], seed * 1'000'003U + i);
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

}  // namespace divemesh::worker
