#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <vector>

#include "worker/types/landmark.hpp"

namespace divemesh::loops {

// A landmark of one visit, found again in a keyframe of another visit.
struct Reobservation {
    std::size_t landmark = 0;  // index into Track::landmarks
    types::LandmarkObservation seen;
};

// Two keyframes that show the same place, with the relative pose measured by their images.
struct Loop {
    std::size_t from = 0;  // the earlier keyframe
    std::size_t to = 0;
    Eigen::Isometry3d T_from_to = Eigen::Isometry3d::Identity();
    double sigma_m = 0.0;  // of its translation
    std::vector<Reobservation> reobservations;
};

}  // namespace divemesh::loops
