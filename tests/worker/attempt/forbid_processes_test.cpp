// Everything runs in a child process, because the restriction cannot be lifted again.
#include "worker/attempt/forbid_processes.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <cerrno>
#include <csignal>
#include <linux/sched.h>
#include <spawn.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <thread>
#include <unistd.h>

namespace divemesh::attempt {
namespace {

template <class Function>
int exit_code_of(const Function& function) {
    const pid_t child = fork();
    if (child == 0) _exit(function());
    int status = 0;
    waitpid(child, &status, 0);
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

// Returns the errno of `call` after processes are forbidden; 0 if it succeeds, -1 if processes
// cannot be forbidden.
template <class Call>
int error_after(const Call& call) {
    const int code = exit_code_of([&] {
        if (!forbid_processes()) return 200;
        errno = 0;
        return call() < 0 ? errno : 0;
    });
    return code == 200 ? -1 : code;
}

char* const* arguments() {
    static char name[] = "true";
    static char* const list[] = {name, nullptr};
    return list;
}

TEST(ForbidProcessesTest, ForkingAndExecutingFail) {
    EXPECT_EQ(error_after([] { return fork(); }), EPERM);
#if defined(__x86_64__)
    EXPECT_EQ(error_after([] { return syscall(SYS_vfork); }), EPERM);
#endif
    EXPECT_EQ(error_after([] { return syscall(SYS_clone, SIGCHLD, 0, 0, 0, 0); }), EPERM);
    EXPECT_EQ(error_after([] { return syscall(SYS_clone3, nullptr, 0); }), ENOSYS);
    EXPECT_EQ(error_after([] { return execv("/bin/true", arguments()); }), EPERM);
    EXPECT_EQ(error_after(
                  [] { return syscall(SYS_execveat, -100, "/bin/true", arguments(), nullptr, 0); }),
              EPERM);
    EXPECT_EQ(exit_code_of([] {
                  pid_t pid = 0;
                  return forbid_processes()
                             ? posix_spawn(
                                   &pid, "/bin/true", nullptr, nullptr, arguments(), nullptr)
                             : 200;
              }),
              EPERM);
}

#if defined(__x86_64__)
TEST(ForbidProcessesTest, TheOtherInterfacesToTheKernelAreClosed) {
    EXPECT_EQ(error_after([] { return syscall(0x4000'0000 | SYS_getpid); }), EPERM);  // x32
    EXPECT_EQ(error_after([] {
                  int pid = 20;  // the number of getpid for 32-bit programs
                  asm volatile("int $0x80" : "+a"(pid) : : "memory");
                  errno = -pid;
                  return pid;
              }),
              EPERM);
}
#endif

TEST(ForbidProcessesTest, ThreadsGoOnWorking) {
    EXPECT_EQ(exit_code_of([] {
                  if (!forbid_processes()) return 200;
                  int value = 0;
                  std::thread([&] { value = 7; }).join();
                  return value;
              }),
              7);
}

TEST(ForbidProcessesTest, ThreadsThatRanBeforeAreHeldToIt) {
    EXPECT_EQ(exit_code_of([] {
                  std::atomic<bool> forbidden = false;
                  int error = 0;
                  std::thread early([&] {
                      while (!forbidden) std::this_thread::yield();
                      error = fork() < 0 ? errno : 0;
                  });
                  const bool done = forbid_processes();
                  forbidden = true;
                  early.join();
                  return done ? error : 200;
              }),
              EPERM);
}

}  // namespace
}  // namespace divemesh::attempt
