#pragma once

namespace divemesh::mesh {

struct alignas(32) AlignedElsewhere {
    int value = 0;
};

}  // namespace divemesh::mesh
