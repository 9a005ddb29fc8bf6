#pragma once

// Marks a place where a test may kill the process: before every statement and commit of the
// catalog, and before every step by which a blob becomes durable. Does nothing without
// DIVEMESH_FAULT_POINTS.
namespace divemesh::storage {

#ifdef DIVEMESH_FAULT_POINTS
void fault_point();
// Raises SIGKILL at the fault point with this number, counted from now: 1 is the next one.
void kill_at_fault_point(int number);
#else
inline void fault_point() {}
#endif

}  // namespace divemesh::storage
