#include "worker/base/parallel.hpp"

#include <algorithm>
#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>

namespace divemesh::base {
namespace {

void run(int num_threads,
         std::size_t begin,
         std::size_t end,
         const std::function<void(std::size_t)>& work) {
    tbb::task_arena arena(num_threads > 0 ? num_threads : tbb::task_arena::automatic);
    arena.execute([&] {
        tbb::parallel_for(tbb::blocked_range<std::size_t>(begin, end), [&](const auto& range) {
            for (std::size_t i = range.begin(); i < range.end(); ++i) work(i);
        });
    });
}

}  // namespace

void ProgressShare::at(double fraction) const {
    Progress progress;
    progress.stage = stage;
    progress.fraction = begin + (end - begin) * fraction;
    report(progress);
}

void for_each_index(int num_threads,
                    std::size_t num,
                    const std::function<void(std::size_t)>& work) {
    run(num_threads, 0, num, work);
}

void for_each_index(int num_threads,
                    std::size_t num,
                    const ProgressShare& progress,
                    const std::function<void(std::size_t)>& work) {
    // Each slice wakes the threads, so there are few slices; but a slice bounds the memory in use.
    const std::size_t slice = std::clamp<std::size_t>(num / 64, 2048, 32768);
    for (std::size_t begin = 0; begin < num; begin += slice) {
        progress.at(static_cast<double>(begin) / static_cast<double>(num));
        run(num_threads, begin, std::min(num, begin + slice), work);
    }
    progress.at(1.0);
}

}  // namespace divemesh::base
