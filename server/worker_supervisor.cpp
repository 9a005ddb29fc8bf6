#include "server/worker_supervisor.hpp"

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <csignal>
#include <linux/close_range.h>
#include <mutex>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include "schemas/log.hpp"

namespace divemesh::server {
namespace {

using Clock = std::chrono::steady_clock;
using namespace std::chrono_literals;

constexpr auto kCheckEvery = 100ms;
constexpr Clock::duration kFirstPause = 1s;
constexpr Clock::duration kMaxPause = 30s;
constexpr auto kSettled = 60s;  // after this time a restart has a short pause again
constexpr auto kGrace = 8s;     // between SIGTERM and SIGKILL

struct Worker {
    pid_t pid = -1;  // -1: not running
    Clock::time_point began;
    Clock::time_point start_at = Clock::now();
    Clock::duration pause = kFirstPause;
};

// Starts a worker. Between fork and exec only system calls are allowed, because other threads may
// hold any lock. The death signal is tied to the thread that forks, so one thread does all of this.
pid_t spawn(const std::vector<std::string>& command) {
    std::vector<char*> arguments;
    arguments.reserve(command.size() + 1);
    for (const std::string& text : command) arguments.push_back(const_cast<char*>(text.c_str()));
    arguments.push_back(nullptr);
    const pid_t parent = getpid();
    const pid_t pid = fork();
    if (pid != 0) return pid;
    prctl(PR_SET_PDEATHSIG, SIGTERM);
    if (getppid() != parent) _exit(1);
    sigset_t none;
    sigemptyset(&none);
    sigprocmask(SIG_SETMASK, &none, nullptr);
    std::signal(SIGPIPE, SIG_DFL);
    // Otherwise a worker that outlives a killed server holds its port and its clients' connections.
    close_range(STDERR_FILENO + 1, ~0U, CLOSE_RANGE_CLOEXEC);
    dup2(STDERR_FILENO, STDOUT_FILENO);  // stdout is for the server's address
    execv(arguments[0], arguments.data());
    _exit(127);
}

void start(Worker& worker, const std::vector<std::string>& command) {
    worker.pid = spawn(command);
    worker.began = Clock::now();
    log_info({{"event", "worker_started"}, {"pid", worker.pid}});
}

// Returns true when it has ended.
bool look_after(Worker& worker) {
    int status = 0;
    if (waitpid(worker.pid, &status, WNOHANG) == 0) return false;
    const auto now = Clock::now();
    if (now - worker.began > kSettled) worker.pause = kFirstPause;
    log_warning({{"event", "worker_ended"},
                 {"pid", worker.pid},
                 {"exit_code", WIFEXITED(status) ? WEXITSTATUS(status) : -1},
                 {"signal", WIFSIGNALED(status) ? WTERMSIG(status) : 0}});
    worker.pid = -1;
    worker.start_at = now + worker.pause;
    worker.pause = std::min(worker.pause * 2, kMaxPause);
    return true;
}

void end_all(std::vector<Worker>& workers) {
    for (const Worker& worker : workers)
        if (worker.pid > 0) kill(worker.pid, SIGTERM);
    const auto end = Clock::now() + kGrace;
    for (Worker& worker : workers) {
        while (worker.pid > 0 && !look_after(worker)) {
            if (Clock::now() >= end) kill(worker.pid, SIGKILL);
            std::this_thread::sleep_for(10ms);
        }
    }
}

}  // namespace

WorkerSupervisor::WorkerSupervisor(std::vector<std::string> command, int num_workers)
    : command_(std::move(command)),
      num_workers_(num_workers),
      thread_([this](const std::stop_token& stop) { run(stop); }) {}

WorkerSupervisor::~WorkerSupervisor() = default;

void WorkerSupervisor::run(const std::stop_token& stop) {
    std::vector<Worker> workers(static_cast<std::size_t>(num_workers_));
    std::mutex mutex;
    std::condition_variable_any stopped;
    while (!stop.stop_requested()) {
        for (Worker& worker : workers) {
            if (worker.pid > 0) look_after(worker);
            if (worker.pid <= 0 && Clock::now() >= worker.start_at) start(worker, command_);
        }
        std::unique_lock lock(mutex);
        stopped.wait_for(lock, stop, kCheckEvery, [] { return false; });
    }
    end_all(workers);
}

}  // namespace divemesh::server
