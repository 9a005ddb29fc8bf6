#pragma once

#include <Eigen/Core>

namespace divemesh::types {

// The error of one camera's calibration: relative focal length (both axes), principal point (px)
// and the first two distortion coefficients.
struct LensChange {
    static constexpr int kSize = 5;
    static constexpr int kFocal = 0;
    static constexpr int kCentreDown = 2;
    static constexpr int kK1 = 3;
    static constexpr int kK2 = 4;
    using Vector = Eigen::Matrix<double, kSize, 1>;

    Vector values = Vector::Zero();  // focal length, cx, cy, k1, k2
};

}  // namespace divemesh::types
