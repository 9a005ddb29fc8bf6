#pragma once

#include <Eigen/Geometry>
#include <gmock/gmock.h>
#include <numbers>

namespace divemesh::synthetic {

// Matches a pose near `expected`; on failure it prints the error in degrees and metres.
MATCHER_P3(IsPoseWithin, expected, degrees, metres, "") {
    const Eigen::Isometry3d difference = expected.inverse() * arg;
    const double rotation_deg =
        Eigen::AngleAxisd(difference.linear()).angle() * 180.0 / std::numbers::pi;
    const double shift_m = difference.translation().norm();
    *result_listener << "off by " << rotation_deg << " degrees and " << shift_m << " m";
    return rotation_deg <= degrees && shift_m <= metres;
}

}  // namespace divemesh::synthetic
