#pragma once

#include "worker/types/rectified_rig.hpp"

namespace divemesh::fusion {

// Returns 2.5 pixels at the median depth, or the standard deviation of the depth there if that is
// larger, rounded to the millimetre: about 1 cm at 2 m for a rig of 500 px and 12 cm.
double choose_voxel_m(const types::RectifiedRig& rig, double median_depth_m);

// Returns the depth at which the depth's standard deviation reaches six voxels: beyond it a view
// adds too little. With four voxels a sixth of the tank within 10 mm is lost, with nine there is no
// gain.
double choose_max_depth_m(const types::RectifiedRig& rig, double voxel_m);

inline constexpr double kMaxSigma_voxels = 6.0;       // of a depth that may make surface
inline constexpr double kMinDisparitySigma_px = 0.1;  // lower bound of all stated values

// Returns the voxel by which the noise of surface is judged at a level, m: at finer levels than
// that of the median depth its `median_voxel_m`, as such surface was seen from farther away too. At
// coarser ones it grows by a fifth per level: with all of the level's voxel 4.2 % of the barge are
// farther than 50 mm from the truth, with this 1.8 % (without levels 1.7 %), with that of the
// median depth alone 4 % of what lies within 20 mm are lost. Where most of a dive is near that
// would leave out a hall 5 m away, so that a standard deviation of 1.7 % of the level's depth is
// always allowed.
double tolerated_voxel_m(const types::RectifiedRig& rig, double median_voxel_m, int num_coarser);

// Returns the depth beyond which voxels chosen for the median depth make no surface at any level:
// the standard deviation of the depth is there at least six of the largest voxels by which it is
// judged (TsdfVolume).
double farthest_surface_m(const types::RectifiedRig& rig, double median_depth_m);

inline constexpr int kMinRelativeLevel = -6;
inline constexpr int kMaxRelativeLevel = 5;

// Returns how often the voxel of the median depth is to be doubled (below 0: halved) for surface at
// a depth: as 2.5 pixels grow there, or half the standard deviation of the depth.
int relative_level(const types::RectifiedRig& rig, double median_depth_m, double depth_m);

}  // namespace divemesh::fusion
