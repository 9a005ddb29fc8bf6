#pragma once

namespace divemesh::attempt {

// From here on this process and its threads start no other process and become no other program:
// fork, vfork, clone without shared memory and exec fail with EPERM (seccomp-bpf). Threads go on
// working. Cannot be undone. False where the kernel has no seccomp filters.
[[nodiscard]] bool forbid_processes();

}  // namespace divemesh::attempt
