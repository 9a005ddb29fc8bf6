#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "worker/dive/marker_plan.hpp"
#include "worker/simulator/diver_motion.hpp"
#include "worker/simulator/scene.hpp"
#include "worker/simulator/simulate.hpp"
#include "worker/types/rig.hpp"

namespace divemesh::simulator {

// A board with a tag, where it was laid; it stays there from year to year.
struct LaidMarker {
    int id = 0;
    Eigen::Isometry3f T_world_board = Eigen::Isometry3f::Identity();  // origin: its lower side
};

// Lays boards with tags 0, 1, 2, ... on the ground where the left camera looks on its way, at least
// two boards apart, on the slope that they find: first where the middle of the picture looks, then
// nearer to the diver. Throws Error{InvalidArgument} when there is no room for as many.
std::vector<LaidMarker> lay_markers(const SimulateOptions& options,
                                    const types::Rig& rig,
                                    const DiverMotion& motion,
                                    const Scene& ground);

// Those of which the ground below is in `after` what it was in `before`: where it rose, sank or
// went, so did the board.
std::vector<LaidMarker> unmoved_markers(const std::vector<LaidMarker>& markers,
                                        const SimulateOptions& options,
                                        const Scene& before,
                                        const Scene& after);

void put_markers(const std::vector<LaidMarker>& markers,
                 const SimulateOptions& options,
                 Scene& scene);

// Their printed size and the exact distances of neighbours and of every second one.
dive::MarkerPlan plan_of(const std::vector<LaidMarker>& markers, const SimulateOptions& options);

}  // namespace divemesh::simulator
