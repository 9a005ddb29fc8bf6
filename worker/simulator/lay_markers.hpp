#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "worker/dive/marker_plan.hpp"
#include "worker/simulator/diver_motion.hpp"
#include "worker/simulator/scene.hpp"
#include "worker/simulator/simulate.hpp"
#include "worker/types/rig.hpp"

namespace divemesh::simulator {

// A board with a tag at its place, the same every year.
struct LaidMarker {
    int id = 0;
    Eigen::Isometry3f T_world_board = Eigen::Isometry3f::Identity();  // origin: underside
};

// Lays boards with tags 0, 1, 2, ... on the ground where the left camera looks along its path, at
// least two board widths apart and on the slope of the ground: first at the centre of the image,
// then nearer to the diver. Throws Error{InvalidArgument} if there is not enough room.
std::vector<LaidMarker> lay_markers(const SimulateOptions& options,
                                    const types::Rig& rig,
                                    const DiverMotion& motion,
                                    const Scene& ground);

// Returns the markers whose ground is the same in `after` as in `before`: where the ground rose,
// sank or disappeared, the board moved too.
std::vector<LaidMarker> unmoved_markers(const std::vector<LaidMarker>& markers,
                                        const SimulateOptions& options,
                                        const Scene& before,
                                        const Scene& after);

// Adds the boards of the markers to a scene.
void put_markers(const std::vector<LaidMarker>& markers,
                 const SimulateOptions& options,
                 Scene& scene);

// Returns the centre of the tag.
Eigen::Vector3d middle_world(const LaidMarker& marker);

// Returns the plan with the printed size and the exact distances of neighbours and of every second
// one.
dive::MarkerPlan plan_of(const std::vector<LaidMarker>& markers, const SimulateOptions& options);

}  // namespace divemesh::simulator
