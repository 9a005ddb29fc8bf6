#pragma once

#include <cstddef>
#include <functional>

#include "worker/base/observer.hpp"

namespace divemesh::base {

// Calls work(i) for i in [0, num) on `num_threads` threads (0: all cores), in any order: what each
// call writes must belong to its i alone, so that the result does not depend on the threads. What a
// call throws comes out here.
void for_each_index(int num_threads, std::size_t num, const std::function<void(std::size_t)>& work);

// A share of a stage's progress: a long loop in slices, so that it can be reported and cancelled.
struct ProgressShare {
    std::string stage;
    double begin = 0.0;
    double end = 1.0;
    ProgressCallback report = ignore_progress;

    void at(double fraction) const;
};

void for_each_index(int num_threads,
                    std::size_t num,
                    const ProgressShare& progress,
                    const std::function<void(std::size_t)>& work);

}  // namespace divemesh::base
