#pragma once

#include <functional>
#include <memory>
#include <oneapi/tbb/task_arena.h>
#include <oneapi/tbb/task_group.h>

namespace divemesh::base {

// The cores that work beside the caller. With one thread everything happens in order, in the
// caller's own time: what is computed never depends on the number.
class TaskPool {
public:
    // 0: all cores.
    explicit TaskPool(int num_threads)
        : arena_(num_threads > 0 ? num_threads : oneapi::tbb::task_arena::automatic) {}

private:
    friend class BackgroundTask;
    oneapi::tbb::task_arena arena_;
};

// One piece of work at a time beside the caller; with one thread, when it is waited for. What it
// throws comes out at the next wait().
class BackgroundTask {
public:
    explicit BackgroundTask(TaskPool& task_pool) : arena_(task_pool.arena_) {}
    ~BackgroundTask();  // waits; what is thrown then is lost, as the caller is already giving up
    BackgroundTask(const BackgroundTask&) = delete;
    BackgroundTask& operator=(const BackgroundTask&) = delete;

    // Waits for the piece before. Who waits for a piece that nobody has begun does it himself, and
    // never another one: a task group's wait would take up whatever is there, however long.
    void run(std::function<void()> work);
    void wait();
    // Whether somebody is at it: to wait now would be idle time.
    bool is_running() const;

private:
    class Task;

    oneapi::tbb::task_arena& arena_;
    oneapi::tbb::task_group group_;
    std::shared_ptr<Task> task_;
};

}  // namespace divemesh::base
