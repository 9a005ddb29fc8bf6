#pragma once

#include <malloc.h>

namespace divemesh::base {

// Hands what was freed back to the system. The allocator keeps it otherwise, and what the next
// stage takes comes on top of it.
inline void return_freed_memory() { malloc_trim(0); }

}  // namespace divemesh::base
