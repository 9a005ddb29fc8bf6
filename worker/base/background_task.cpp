#include "worker/base/background_task.hpp"

#include <atomic>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <utility>

namespace divemesh::base {

class BackgroundTask::Task {
public:
    explicit Task(std::function<void()> work) : work_(std::move(work)) {}

    void run_unless_taken() {
        if (taken_.test_and_set()) return;
        try {
            work_();
        } catch (...) {
            failure_ = std::current_exception();
        }
        work_ = nullptr;
        const std::lock_guard lock(mutex_);
        done_ = true;
        changed_.notify_all();
    }

    bool is_running() {
        const std::lock_guard lock(mutex_);
        return taken_.test() && !done_;
    }

    void wait() {
        run_unless_taken();
        std::unique_lock lock(mutex_);
        changed_.wait(lock, [this] { return done_; });
        if (failure_) std::rethrow_exception(failure_);
    }

private:
    std::function<void()> work_;
    std::atomic_flag taken_;
    std::mutex mutex_;
    std::condition_variable changed_;
    bool done_ = false;
    std::exception_ptr failure_;
};

BackgroundTask::~BackgroundTask() {
    try {
        wait();
    } catch (...) {  // see the declaration
    }
    // Waits for the group's entries of tasks that the caller ran itself.
    arena_.execute([this] { group_.wait(); });
}

void BackgroundTask::run(std::function<void()> work) {
    wait();
    task_ = std::make_shared<Task>(std::move(work));
    if (arena_.max_concurrency() > 1)
        arena_.execute([this] { group_.run([task = task_] { task->run_unless_taken(); }); });
}

void BackgroundTask::wait() {
    if (const auto task = std::exchange(task_, nullptr)) task->wait();
}

bool BackgroundTask::is_running() const { return task_ && task_->is_running(); }

}  // namespace divemesh::base
