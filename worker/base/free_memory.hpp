#pragma once

#include <malloc.h>

namespace divemesh::base {

// Returns freed memory to the system. Otherwise the allocator keeps it, and the next stage's memory
// comes on top.
inline void return_freed_memory() { malloc_trim(0); }

}  // namespace divemesh::base
