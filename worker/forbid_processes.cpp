#include "worker/forbid_processes.hpp"

#include <array>
#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <linux/audit.h>
#include <linux/filter.h>
#include <linux/sched.h>
#include <linux/seccomp.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <unistd.h>

namespace divemesh::worker {
namespace {

#if defined(__x86_64__)
constexpr std::uint32_t kArchitecture = AUDIT_ARCH_X86_64;
#elif defined(__aarch64__)
constexpr std::uint32_t kArchitecture = AUDIT_ARCH_AARCH64;
#else
#error "the number of this architecture is not known here"
#endif
constexpr std::uint32_t kX32 = 0x4000'0000;  // system calls of another interface to the same kernel

constexpr std::uint32_t refuse(int error) {
    return SECCOMP_RET_ERRNO | static_cast<std::uint32_t>(error);
}
constexpr sock_filter load(std::size_t offset) {
    return BPF_STMT(BPF_LD | BPF_W | BPF_ABS, static_cast<std::uint32_t>(offset));
}
constexpr sock_filter give(std::uint32_t answer) { return BPF_STMT(BPF_RET | BPF_K, answer); }
constexpr sock_filter skip_unless_equal(std::uint32_t value) {
    return BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, value, 0, 1);
}

constexpr auto kProgram = std::to_array<sock_filter>({
    load(offsetof(seccomp_data, arch)), BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, kArchitecture, 1, 0),
        give(refuse(EPERM)), load(offsetof(seccomp_data, nr)),
#if defined(__x86_64__)
        BPF_JUMP(BPF_JMP | BPF_JGE | BPF_K, kX32, 0, 1), give(refuse(EPERM)),
        skip_unless_equal(__NR_fork), give(refuse(EPERM)), skip_unless_equal(__NR_vfork),
        give(refuse(EPERM)),
#endif
        skip_unless_equal(__NR_execve), give(refuse(EPERM)), skip_unless_equal(__NR_execveat),
        give(refuse(EPERM)),
        // Its flags lie in memory, out of a filter's sight. The C library falls back to clone.
        skip_unless_equal(__NR_clone3), give(refuse(ENOSYS)),
        // Leak checkers stop the world from a clone that shares memory and is no thread.
        BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, __NR_clone, 0, 3),
        load(offsetof(seccomp_data, args)),  // the low half: both architectures are little-endian
        BPF_JUMP(BPF_JMP | BPF_JSET | BPF_K, CLONE_VM, 1, 0), give(refuse(EPERM)),
        give(SECCOMP_RET_ALLOW),
});

}  // namespace

bool forbid_processes() {
    auto program = kProgram;
    const sock_fprog filter{static_cast<unsigned short>(program.size()), program.data()};
    return prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) == 0 &&
           syscall(SYS_seccomp, SECCOMP_SET_MODE_FILTER, SECCOMP_FILTER_FLAG_TSYNC, &filter) == 0;
}

}  // namespace divemesh::worker
