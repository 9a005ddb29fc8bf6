#pragma once

#include <cstddef>
#include <functional>

#include "worker/base/observer.hpp"

namespace divemesh::base {

// Calls work(i) for i in [0, num) on `num_threads` threads (0: all cores), in any order. Each call
// may write only data that belong to its i, so that the result does not depend on the threads.
// Exceptions of a call are rethrown here.
void for_each_index(int num_threads, std::size_t num, const std::function<void(std::size_t)>& work);

// The share of a stage's progress that one loop covers.
struct ProgressShare {
    std::string stage;
    double begin = 0.0;
    double end = 1.0;
    ProgressCallback report = ignore_progress;

    // Reports `fraction` of this share as done; throws Error{Cancelled} if the callback does.
    void at(double fraction) const;
};

void for_each_index(int num_threads,
                    std::size_t num,
                    const ProgressShare& progress,
                    const std::function<void(std::size_t)>& work);

}  // namespace divemesh::base
