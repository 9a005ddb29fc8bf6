#pragma once

namespace divemesh::camera {

struct Lens {
    double focal_m = 0.0;
};

}  // namespace divemesh::camera
