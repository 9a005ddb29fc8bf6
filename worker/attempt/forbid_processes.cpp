#include "worker/attempt/forbid_processes.hpp"

#include <cerrno>
#include <cstdint>
#include <memory>
#include <sched.h>
#include <seccomp.h>

namespace divemesh::attempt {
namespace {

constexpr std::uint32_t kRefuse = SCMP_ACT_ERRNO(EPERM);

// System calls that the machine does not have are skipped. Those of another interface of the same
// kernel (32 bits, x32) are all refused.
bool add_rules(scmp_filter_ctx filter) {
    for (const int call : {SCMP_SYS(fork), SCMP_SYS(vfork), SCMP_SYS(execve), SCMP_SYS(execveat)})
        if (seccomp_rule_add(filter, kRefuse, call, 0) != 0) return false;
    // Leak checkers stop the process from a clone that shares memory and is not a thread.
    const scmp_arg_cmp shares_no_memory = {
        .arg = 0, .op = SCMP_CMP_MASKED_EQ, .datum_a = CLONE_VM, .datum_b = 0};
    return seccomp_rule_add_array(filter, kRefuse, SCMP_SYS(clone), 1, &shares_no_memory) == 0 &&
           // clone3's flags are in memory, which a filter cannot read. The C library falls back to
           // clone.
           seccomp_rule_add(filter, SCMP_ACT_ERRNO(ENOSYS), SCMP_SYS(clone3), 0) == 0 &&
           seccomp_attr_set(filter, SCMP_FLTATR_ACT_BADARCH, kRefuse) == 0 &&
           seccomp_attr_set(filter, SCMP_FLTATR_CTL_TSYNC, 1) == 0;  // also for running threads
}

}  // namespace

bool forbid_processes() {
    const std::unique_ptr<void, decltype(&seccomp_release)> filter(seccomp_init(SCMP_ACT_ALLOW),
                                                                   &seccomp_release);
    return filter && add_rules(filter.get()) && seccomp_load(filter.get()) == 0;
}

}  // namespace divemesh::attempt
