#pragma once

#include <chrono>
#include <memory>
#include <string>

namespace divemesh::storage {

// Tells a worker that waits for jobs that one was queued, sooner than its next poll would.
class QueueSignal {
public:
    virtual ~QueueSignal() = default;
    // Returns as soon as a job was queued since the last call, otherwise after `at_most`.
    virtual void wait(std::chrono::milliseconds at_most) = 0;
};

// Returns the signal of the catalog with this URL; null if its engine has none.
std::unique_ptr<QueueSignal> listen_to_queue(const std::string& catalog_url);

}  // namespace divemesh::storage
