#include "worker/base/parallel.hpp"

#include <algorithm>

#include "worker/base/task_threads.hpp"
#if defined(__SANITIZE_THREAD__)
#include <atomic>
#include <exception>
#include <mutex>
#include <vector>
#else
#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/parallel_for.h>
#endif

namespace divemesh::base {
namespace {

#if defined(__SANITIZE_THREAD__)
void run(int num_threads,
         std::size_t begin,
         std::size_t end,
         const std::function<void(std::size_t)>& work) {
    std::atomic<std::size_t> next = begin;
    std::mutex mutex;
    std::exception_ptr failure;
    const auto work_on = [&] {
        try {
            for (std::size_t i = next++; i < end; i = next++) work(i);
        } catch (...) {
            next = end;
            const std::lock_guard lock(mutex);
            failure = std::current_exception();
        }
    };
    std::vector<std::thread> threads;
    for (int i = 1; i < arena_of(num_threads).max_concurrency(); ++i) threads.emplace_back(work_on);
    work_on();
    for (std::thread& thread : threads) thread.join();
    if (failure) std::rethrow_exception(failure);
}
#else
void run(int num_threads,
         std::size_t begin,
         std::size_t end,
         const std::function<void(std::size_t)>& work) {
    TaskArena arena = arena_of(num_threads);
    arena.execute([&] {
        tbb::parallel_for(tbb::blocked_range<std::size_t>(begin, end), [&](const auto& range) {
            for (std::size_t i = range.begin(); i < range.end(); ++i) work(i);
        });
    });
}
#endif

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
