#pragma once

#include <condition_variable>
#include <mutex>
#include <string>
#include <thread>

#include "storage/worker_store.hpp"

namespace divemesh::runner {

// Reports every few seconds that the worker is alive and what it waits for, and in the end that it
// has stopped.
class Registration {
public:
    Registration(storage::Catalog& catalog, std::string name, int num_slots);
    ~Registration();
    Registration(const Registration&) = delete;
    Registration& operator=(const Registration&) = delete;

    // Sets Worker::waits_for. A change is reported at once. From any thread.
    void set_waits_for(const std::string& reason);

private:
    void run(const std::stop_token& stop);

    storage::WorkerStore workers_;
    std::string name_;
    int num_slots_;
    std::mutex mutex_;
    std::condition_variable_any changed_;
    std::string waits_for_;
    std::string reported_;
    std::jthread thread_;  // last: it uses the members above
};

}  // namespace divemesh::runner
