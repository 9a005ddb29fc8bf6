#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "schemas/job.hpp"
#include "storage/catalog.hpp"

namespace divemesh::storage {

// When the result of a job was deleted, and when it is removed for good; 0: it is not deleted.
struct Deletion {
    std::int64_t deleted_at_ms = 0;
    std::int64_t expires_at_ms = 0;
};

// Throws Error{Gone} if the result of a job was deleted.
void require_result(soci::session& session, const std::string& job_id);

// Removes the result of a finished job, its artifacts, in two steps, as DiveRemoval does with a
// dive. The job itself stays, with its metrics.
class ResultRemoval {
public:
    explicit ResultRemoval(Catalog& catalog) : catalog_(catalog) {}

    Deletion deletion_of(const std::string& job_id);  // throws Error{NotFound}
    // Throws Error{Conflict} for a job that is not finished, for an intake, and while another job
    // waits for the result or reads it. A result that is already deleted expires as planned, or
    // sooner.
    void remove(const std::string& job_id, std::chrono::milliseconds keep);
    void restore(const std::string& job_id);  // throws Error{Conflict} if it has expired

    // Deletes what projects do not want to keep (Queue::keep_results), `limit` results at most, and
    // calls `deleted` with each in the same transaction. What was restored stays. Returns how many.
    int remove_old(std::chrono::milliseconds keep,
                   int limit,
                   const std::function<void(soci::session&, const std::string& job_id)>& deleted);

    // Returns jobs with a result that was deleted and has expired, `limit` at most.
    std::vector<std::string> expired(int limit);
    // Returns the prefixes of the keys of a job's artifacts, one per attempt that made some.
    std::vector<std::string> blob_prefixes(const std::string& job_id);
    // Removes the rows of the artifacts, unless the job was tried again; call it after their blobs
    // are removed.
    void forget(const std::string& job_id);

private:
    Catalog& catalog_;
};

}  // namespace divemesh::storage
