#pragma once

#include <mutex>
#include <optional>
#include <string>

#include "schemas/job.hpp"
#include "storage/blob_store.hpp"
#include "storage/catalog.hpp"
#include "worker/runner/job_runner.hpp"

namespace divemesh::runner {

// Decides whether a worker may take a job, so that none is tried without a disk or without the
// blobs of the catalog. Thread-safe.
class WorkerGate {
public:
    WorkerGate(const WorkerConfig& config, storage::Catalog& catalog, storage::BlobStore& blobs)
        : config_(config), catalog_(catalog), blobs_(blobs) {}

    // Returns why it may not, a word of WaitReason; "" if it may. Logs every change. Throws what a
    // failed read of the catalog throws.
    std::string waits_for();

private:
    const WorkerConfig& config_;
    storage::Catalog& catalog_;
    storage::BlobStore& blobs_;
    std::mutex mutex_;
    std::string last_;
};

// Returns the failure of an attempt anew if the worker's own storage explains it: the blobs of the
// catalog are not there any more, or a disk is full and the attempt itself is not to blame.
std::optional<Failure> fault_of_worker(WorkerGate& gate,
                                       const Failure& failure,
                                       bool attempt_is_to_blame);

}  // namespace divemesh::runner
