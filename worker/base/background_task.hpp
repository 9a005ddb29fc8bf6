#pragma once

#include <functional>
#include <memory>

#include "worker/base/task_threads.hpp"

namespace divemesh::base {

// The threads that work beside the caller. With one thread all work runs in order in the caller's
// thread. The results do not depend on the number of threads.
class TaskPool {
public:
    // `num_threads` 0 means all cores.
    explicit TaskPool(int num_threads) : arena_(arena_of(num_threads)) {}

private:
    friend class BackgroundTask;
    TaskArena arena_;
};

// A slot for one task at a time beside the caller; with one thread the task runs when the caller
// waits for it. An exception of the task is rethrown by the next wait().
class BackgroundTask {
public:
    explicit BackgroundTask(TaskPool& task_pool) : arena_(task_pool.arena_) {}
    ~BackgroundTask();  // waits; an exception is lost, as the caller is already unwinding
    BackgroundTask(const BackgroundTask&) = delete;
    BackgroundTask& operator=(const BackgroundTask&) = delete;

    // Waits for the previous task, then starts this one. A caller that waits for a task that has
    // not begun runs it itself. It never runs another task: wait() of a TBB task group would run
    // any task in the arena, however long.
    void run(std::function<void()> work);
    void wait();  // returns at once if there is no task
    // Returns true if another thread is running the task, so that waiting now would be idle time.
    bool is_running() const;

private:
    class Task;

    TaskArena& arena_;
    TaskGroup group_;
    std::shared_ptr<Task> task_;
};

}  // namespace divemesh::base
