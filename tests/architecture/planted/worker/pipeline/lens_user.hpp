#pragma once

#include "worker/camera/lens.hpp"

namespace divemesh::mesh {

struct Elsewhere {
    int value = 0;
};

}  // namespace divemesh::mesh
