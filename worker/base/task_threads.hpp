#pragma once

// The threads of TBB that tasks run on. The thread sanitizer sees no order in TBB, which is not
// instrumented, and would report every hand-over as a race. It therefore watches threads of the
// standard library instead: slower, but what our own code shares is checked.
#if defined(__SANITIZE_THREAD__)

#include <algorithm>
#include <thread>
#include <utility>

namespace divemesh::base {

inline int num_task_threads(int num_threads) {
    if (num_threads > 0) return num_threads;
    return std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

class TaskArena {
public:
    explicit TaskArena(int num_threads) : num_threads_(num_task_threads(num_threads)) {}
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

class TaskArena : public oneapi::tbb::task_arena {
public:
    explicit TaskArena(int num_threads)
        : task_arena(num_threads > 0 ? num_threads : oneapi::tbb::task_arena::automatic) {}
};

using TaskGroup = oneapi::tbb::task_group;

}  // namespace divemesh::base

#endif
