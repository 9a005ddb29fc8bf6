#pragma once

#include "worker/pipeline/lens_user.hpp"

namespace divemesh::camera {

struct Lens {
    int focal_px = 0;
};

}  // namespace divemesh::camera
