// A worker with short timeouts: fake_worker worker CATALOG BLOBS WORK LEASE_MS DEADLINE_MS
// FILE_LIMIT SCRATCH MIN_FREE, and its child: fake_worker attempt REQUEST.
#include <csignal>
#include <stop_token>
#include <string>
#include <sys/resource.h>
#include <thread>

#include "worker/attempt/attempt.hpp"
#include "worker/runner/job_runner.hpp"

namespace {

using std::chrono::milliseconds;

int run_worker(char** arguments) {
    const milliseconds lease(std::stol(arguments[5]));
    const divemesh::runner::WorkerConfig config{
        .catalog_url = arguments[2],
        .blobs_url = arguments[3],
        .work_folder = arguments[4],
        .cache_folder = std::string(arguments[4]) + "-cache",
        .cache_bytes = 12345,
        .lease = lease,
        .renew_every = lease / 5,
        .poll_every = milliseconds(100),
        .deadline = milliseconds(std::stol(arguments[6])),
        .cancel_grace = milliseconds(1000),
        .scratch_bytes = std::stol(arguments[8]),
        .min_free_bytes = std::stol(arguments[9])};
    rlimit limit{};
    getrlimit(RLIMIT_FSIZE, &limit);
    limit.rlim_cur = std::stoul(arguments[7]);
    setrlimit(RLIMIT_FSIZE, &limit);

    sigset_t ending;
    sigemptyset(&ending);
    sigaddset(&ending, SIGTERM);
    pthread_sigmask(SIG_BLOCK, &ending, nullptr);
    std::stop_source stop;
    std::thread([&] {
        int signal = 0;
        sigwait(&ending, &signal);
        stop.request_stop();
    }).detach();
    divemesh::runner::run_worker(config, stop.get_token());
    return 0;
}

}  // namespace

int main(int argc, char** argv) {
    const std::string command = argc > 1 ? argv[1] : "";
    if (command == "attempt" && argc == 3) return divemesh::attempt::run_attempt(argv[2]);
    if (command == "worker" && argc == 10) return run_worker(argv);
    return 2;
}
