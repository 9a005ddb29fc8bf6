#pragma once

#include <string>
#include <thread>
#include <vector>

namespace divemesh::server {

// Keeps `num_workers` worker processes running, each with `command`. Restarts one that ends, after
// a pause that grows while it keeps ending early. The workers die with this process however it
// ends, and get SIGTERM, later SIGKILL, after stop().
class WorkerSupervisor {
public:
    WorkerSupervisor(std::vector<std::string> command, int num_workers);
    ~WorkerSupervisor();
    WorkerSupervisor(const WorkerSupervisor&) = delete;
    WorkerSupervisor& operator=(const WorkerSupervisor&) = delete;

    void stop() { thread_.request_stop(); }  // from any thread; the destructor waits

private:
    void run(const std::stop_token& stop);

    std::vector<std::string> command_;
    int num_workers_;
    std::jthread thread_;  // last: it ends before the members that it uses
};

}  // namespace divemesh::server
