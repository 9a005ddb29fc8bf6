#pragma once

#include <chrono>
#include <string>
#include <vector>

#include "schemas/worker.hpp"
#include "storage/catalog.hpp"

namespace divemesh::storage {

inline constexpr int kWorkerSilence_ms = 20'000;  // a worker silent for longer is not alive

// The workers table: the processes that take jobs. A worker writes its own row; users ask it to
// drain.
class WorkerStore {
public:
    explicit WorkerStore(Catalog& catalog) : catalog_(catalog) {}

    // Adds the worker, or records that it is alive and what it waits for (Worker::waits_for).
    // Removes rows of workers that were silent for a day.
    void report(const std::string& name, int num_slots, const std::string& waits_for = "");
    void remove(const std::string& name);
    // Removes the workers that were silent for so long. One that was told to drain stays for a day,
    // so that it still drains if it was only suspended.
    void forget_silent(std::chrono::milliseconds silence);

    std::vector<Worker> list();           // by name
    Worker get(const std::string& name);  // throws Error{NotFound}
    // Sets whether claim() withholds jobs from it. Throws Error{NotFound}.
    Worker set_draining(const std::string& name, bool draining);

private:
    Catalog& catalog_;
};

}  // namespace divemesh::storage
