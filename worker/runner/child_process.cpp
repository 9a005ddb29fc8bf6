#include "worker/runner/child_process.hpp"

#include <cerrno>
#include <csignal>
#include <cstring>
#include <fcntl.h>
#include <linux/close_range.h>
#include <poll.h>
#include <sched.h>
#include <string_view>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "schemas/error.hpp"
#include "worker/attempt/attempt_protocol.hpp"

namespace divemesh::runner {
namespace {

void limit(int resource, std::int64_t value, std::int64_t hard_extra = 0) {
    if (value <= 0) return;
    const rlimit limits{static_cast<rlim_t>(value), static_cast<rlim_t>(value + hard_extra)};
    setrlimit(static_cast<__rlimit_resource_t>(resource), &limits);
}

// Returns the line of /proc/self/uid_map that keeps the process's user in a new user namespace.
// Must be called before the fork.
std::string own_user_map() {
    const std::string user = std::to_string(geteuid());
    return user + " " + user + " 1\n";
}

// Root needs no user namespace, and in one it would lose its rights to other users' files.
bool cut_network(const std::string& user_map) {
    if (unshare(CLONE_NEWNET) == 0) return true;
    if (unshare(CLONE_NEWUSER | CLONE_NEWNET) != 0) return false;
    const FileDescriptor map(open("/proc/self/uid_map", O_WRONLY | O_CLOEXEC));
    return map.is_open() && write(map.get(), user_map.data(), user_map.size()) ==
                                static_cast<ssize_t>(user_map.size());
}

// Returns whether a variable may hold a secret that only the parent needs: keys of the object
// store, the password of PostgreSQL, a token.
bool may_hold_secret(std::string_view variable) {
    for (const std::string_view name : {"AWS_", "PG", "DIVEMESH_CATALOG=", "DIVEMESH_TOKEN="})
        if (variable.starts_with(name)) return true;
    return false;
}

std::vector<char*> environment_of_child() {
    std::vector<char*> kept;
    for (char** variable = environ; *variable != nullptr; ++variable)
        if (!may_hold_secret(*variable)) kept.push_back(*variable);
    kept.push_back(nullptr);
    return kept;
}

// Runs between fork and exec in a process with threads, so only async-signal-safe calls are
// allowed.
[[noreturn]] void become(char* const* arguments,
                         char* const* environment,
                         int pipe_end,
                         pid_t parent,
                         const ProcessLimits& limits,
                         const std::string& user_map) {
    setpgid(0, 0);
    if (limits.no_network && !cut_network(user_map)) _exit(127);
    // After the user namespace, as entering one resets it.
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (getppid() != parent) _exit(127);  // the parent ended before the line above
    const int null = open("/dev/null", O_RDONLY);
    dup2(null, STDIN_FILENO);
    dup2(pipe_end, attempt::kAttemptPipe);  // dup2 clears close-on-exec
    if (pipe_end == attempt::kAttemptPipe) fcntl(pipe_end, F_SETFD, 0);
    close_range(attempt::kAttemptPipe + 1, ~0U, CLOSE_RANGE_CLOEXEC);
    for (const int ended : {SIGTERM, SIGINT, SIGHUP, SIGPIPE}) std::signal(ended, SIG_DFL);
    sigset_t none;
    sigemptyset(&none);
    sigprocmask(SIG_SETMASK, &none, nullptr);
    limit(RLIMIT_DATA, limits.max_memory_bytes);
    limit(RLIMIT_FSIZE, limits.max_file_bytes);
    limit(RLIMIT_NOFILE, limits.max_open_files);
    limit(RLIMIT_CPU, limits.max_cpu_s, 5);  // SIGXCPU, five seconds later SIGKILL
    const rlimit no_core{0, 0};
    setrlimit(RLIMIT_CORE, &no_core);
    execve(arguments[0], arguments, environment);
    _exit(127);
}

}  // namespace

bool can_cut_network() {
    const std::string user_map = own_user_map();
    const pid_t child = fork();
    if (child == 0) _exit(cut_network(user_map) ? 0 : 1);
    int status = 0;
    while (child > 0 && waitpid(child, &status, 0) < 0 && errno == EINTR) {
    }
    return child > 0 && WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

ChildProcess::ChildProcess(const std::vector<std::string>& command, const ProcessLimits& limits) {
    int ends[2];
    if (pipe2(ends, O_CLOEXEC) != 0)
        throw Error(ErrorCode::Unavailable, std::string("pipe: ") + std::strerror(errno));
    pipe_ = FileDescriptor(ends[0]);
    const FileDescriptor childs_end(ends[1]);
    std::vector<char*> arguments;
    arguments.reserve(command.size() + 1);
    for (const std::string& word : command) arguments.push_back(const_cast<char*>(word.c_str()));
    arguments.push_back(nullptr);
    const std::vector<char*> environment = environment_of_child();
    const pid_t parent = getpid();
    const std::string user_map = own_user_map();

    pid_ = fork();
    if (pid_ == 0)
        become(arguments.data(), environment.data(), childs_end.get(), parent, limits, user_map);
    if (pid_ < 0) throw Error(ErrorCode::Unavailable, std::string("fork: ") + std::strerror(errno));
    setpgid(pid_, pid_);  // parent and child both call it, as either may run first
}

ChildProcess::~ChildProcess() {
    if (!end_) {  // once reaped, the process id may be reused
        signal_group(SIGKILL);
        int status = 0;
        while (waitpid(pid_, &status, 0) < 0 && errno == EINTR) {
        }
    }
}

void ChildProcess::signal_group(int signal) const { kill(-pid_, signal); }

bool ChildProcess::read_some(std::string& buffer, int timeout_ms) {
    pollfd ready{.fd = pipe_.get(), .events = POLLIN, .revents = 0};
    if (poll(&ready, 1, timeout_ms) <= 0) return true;
    char bytes[65536];
    const auto n = ::read(pipe_.get(), bytes, sizeof bytes);
    if (n > 0) buffer.append(bytes, static_cast<std::size_t>(n));
    return n > 0 || (n < 0 && errno == EINTR);
}

std::optional<ProcessEnd> ChildProcess::poll_end() {
    if (end_) return end_;
    siginfo_t ended{};
    if (waitid(P_PID, static_cast<id_t>(pid_), &ended, WEXITED | WNOHANG | WNOWAIT) != 0 ||
        ended.si_pid != pid_)
        return std::nullopt;
    signal_group(SIGKILL);  // the processes it started; until it is reaped, its id is not reused
    int status = 0;
    while (waitpid(pid_, &status, 0) < 0 && errno == EINTR) {
    }
    end_ = WIFSIGNALED(status) ? ProcessEnd{.signal = WTERMSIG(status)}
                               : ProcessEnd{.exit_code = WEXITSTATUS(status)};
    return end_;
}

}  // namespace divemesh::runner
