#pragma once

#include <cstdint>
#include <sys/types.h>

namespace divemesh {

// Of another process, by proc(5).
std::int64_t peak_memory_bytes_of(pid_t pid);  // VmHWM; -1: not known
double cpu_seconds_of(pid_t pid);              // user and system so far

}  // namespace divemesh
