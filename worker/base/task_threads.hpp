#pragma once

// The threads of TBB that tasks run on. The thread sanitizer sees no order in TBB, which is not
// instrumented, and would report every hand-over as a race. It therefore watches threads of the
// standard library instead: slower, but what our own code shares is checked.
#if defined(__SANITIZE_THREAD__)

#include <algorithm>
#include <thread>
#include <utility>

namespace divemesh::base {

class TaskArena {
public:
    static constexpr int automatic = -1;
    explicit TaskArena(int num_threads)
        : num_threads_(num_threads != automatic
                           ? num_threads
                           : std::max(1, static_cast<int>(std::thread::hardware_concurrency()))) {}
    int max_concurrency() const { return num_threads_; }
    template <typename Function>
    void execute(const Function& function) const {
        function();
    }

private:
    int num_threads_;
};

// Runs one task at a time.
class TaskGroup {
public:
    TaskGroup() = default;
    ~TaskGroup() { wait(); }
    TaskGroup(const TaskGroup&) = delete;
    TaskGroup& operator=(const TaskGroup&) = delete;

    template <typename Function>
    void run(Function function) {
        wait();
        thread_ = std::thread(std::move(function));
    }
    void wait() {
        if (thread_.joinable()) thread_.join();
    }

private:
    std::thread thread_;
};

}  // namespace divemesh::base

#else

#include <oneapi/tbb/task_arena.h>
#include <oneapi/tbb/task_group.h>

namespace divemesh::base {

using TaskArena = oneapi::tbb::task_arena;
using TaskGroup = oneapi::tbb::task_group;

}  // namespace divemesh::base

#endif

namespace divemesh::base {

// Returns the arena of `num_threads` threads; 0: all cores.
inline TaskArena arena_of(int num_threads) {
    return TaskArena(num_threads > 0 ? num_threads : TaskArena::automatic);
}

}  // namespace divemesh::base
