#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "worker/evaluation/trajectory_pairs.hpp"

namespace divemesh::evaluation {

// The alignment of an estimate with a reference.
struct Alignment {
    Eigen::Isometry3d T_reference_world = Eigen::Isometry3d::Identity();  // scale 1
    double sim3_scale = 1.0;  // best-fitting scale for the same rotation
};

// Aligns the positions by least squares (Umeyama 1991). If they lie on a line, the rotation about
// it comes from the orientations, each with the weight of three points at a distance of 1 m.
Alignment align(const std::vector<PosePair>& pairs);

// Returns the SE(3) of least squares over positions and orientations, each orientation with the
// weight of three points at a distance of 1 m. It places a surface that was seen from these poses.
// Positions alone leave the roll of a nearly straight path to their noise: a millimetre across 5 cm
// is a degree, and a degree is 3 cm at 2 m.
Eigen::Isometry3d align_poses(const std::vector<PosePair>& pairs);

// Returns the aligned positions scaled about their centre by sim3_scale instead of 1: the Sim(3)
// alignment in the reference frame.
std::vector<Eigen::Vector3d> scaled_about_centre(const std::vector<PosePair>& pairs,
                                                 const Alignment& alignment);

}  // namespace divemesh::evaluation
