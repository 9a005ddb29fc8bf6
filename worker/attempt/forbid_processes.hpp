#pragma once

namespace divemesh::attempt {

// Forbids this process and its threads, from now on, to start other processes or programs: fork,
// vfork, clone without shared memory and exec fail with EPERM (seccomp-bpf). Threads still work. It
// cannot be undone. Returns false if the kernel has no seccomp filters.
[[nodiscard]] bool forbid_processes();

}  // namespace divemesh::attempt
