#pragma once

#include <optional>
#include <string>

#include "schemas/queue.hpp"
#include "storage/catalog.hpp"

namespace divemesh::storage {

struct QueueChange {
    std::optional<bool> paused = std::nullopt;
    std::optional<int> max_running = std::nullopt;
    std::optional<int> keep_results = std::nullopt;
};

// The queues table: pauses and limits of a project, or of all projects together (project "").
class QueueStore {
public:
    explicit QueueStore(Catalog& catalog) : catalog_(catalog) {}

    Queue get(const std::string& project);
    // Returns why no job of any project starts, a word of WaitReason; "": jobs start.
    std::string waits_for();
    // Running jobs continue. Throws Error{InvalidArgument} for a number below 0.
    Queue change(const std::string& project, const QueueChange& change);

private:
    Catalog& catalog_;
};

}  // namespace divemesh::storage
