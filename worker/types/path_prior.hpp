#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

namespace divemesh::types {

// What vision and inertial sensors know of some keyframes of an adjusted path together, relative to
// the first of them. Six rows per keyframe: position of the body, m, then rotation vector, rad,
// both in the axes of the world. Empty: it was not asked for, or is not determined.
struct PathPrior {
    std::vector<std::int64_t> timestamps_ns;
    // Along world x, of how far the segment of each keyframe was set apart from where it was
    // estimated to be, m.
    std::vector<double> apart_m;
    Eigen::MatrixXd drift;   // covariance with the calibration taken as exact
    Eigen::MatrixXd shared;  // what each error of the calibration adds, one sigma per column

    bool empty() const { return timestamps_ns.empty(); }
};

}  // namespace divemesh::types
