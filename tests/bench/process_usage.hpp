#pragma once

#include <cstdint>
#include <sys/types.h>

namespace divemesh {

// Returns the peak resident memory of a process (VmHWM of proc(5)); -1 if unknown.
std::int64_t peak_memory_bytes_of(pid_t pid);
// Returns the CPU time of a process until now, user and system, s.
double cpu_seconds_of(pid_t pid);

}  // namespace divemesh
