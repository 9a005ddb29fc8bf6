#pragma once

#include <string>
#include <vector>

#include "schemas/worker.hpp"
#include "storage/catalog.hpp"

namespace divemesh::storage {

inline constexpr int kWorkerSilence_ms = 20'000;  // who was not heard of for longer is not alive

// The workers table: who takes jobs. A worker writes its own row, people ask it to drain.
class WorkerStore {
public:
    explicit WorkerStore(Catalog& catalog) : catalog_(catalog) {}

    // Adds the worker, or says that it is still there. Rows of workers that were not heard of for a
    // day go.
    void report(const std::string& name, int num_slots);
    void remove(const std::string& name);

    std::vector<Worker> list();           // by name
    Worker get(const std::string& name);  // throws Error{NotFound}
    // Draining: claim() gives it nothing more. Throws Error{NotFound}.
    Worker set_draining(const std::string& name, bool draining);

private:
    Catalog& catalog_;
};

}  // namespace divemesh::storage
