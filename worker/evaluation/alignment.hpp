#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "worker/evaluation/trajectory_pairs.hpp"

namespace divemesh::evaluation {

struct Alignment {
    Eigen::Isometry3d T_reference_world = Eigen::Isometry3d::Identity();  // scale 1
    double sim3_scale = 1.0;  // the scale that would fit best beside the same rotation
};

// Least squares over the positions (Umeyama 1991). Where they lie on a line, the rotation about it
// comes from the orientations, each weighing as three points 1 m off would.
Alignment align(const std::vector<PosePair>& pairs);

// Least squares over positions and orientations alike, each orientation weighing as three points
// 1 m off would: where a surface that was seen from these poses belongs. Positions alone leave the
// roll of a nearly straight path to their noise: a millimetre across 5 cm is a degree, and a degree
// is 3 cm at 2 m.
Eigen::Isometry3d align_poses(const std::vector<PosePair>& pairs);

// `aligned` with the best scale about the centre instead of 1: Sim(3) positions in the reference.
std::vector<Eigen::Vector3d> scaled_about_centre(const std::vector<PosePair>& pairs,
                                                 const Alignment& alignment);

}  // namespace divemesh::evaluation
