#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <thread>

namespace divemesh::runner {

// The result of renewing a lease.
enum class LeaseStatus { Valid, CancelRequested, Lost };

// Calls that renew or check a lease, made from the keeper's thread.
struct LeaseCalls {
    std::function<LeaseStatus()> renew;
    // Checks without renewing: cheap, notices a cancel request quickly.
    std::function<LeaseStatus()> check_lease;
};

struct LeaseTimes {
    std::chrono::milliseconds lease;
    std::chrono::milliseconds renew_every;
    std::chrono::milliseconds check_every;
};

// Renews a lease by timer in its own thread, so that neither a slow disk nor a busy child lets it
// expire. If renewing fails for the duration of the lease (the catalog is not reachable), the lease
// counts as lost.
class LeaseKeeper {
public:
    LeaseKeeper(LeaseCalls calls, const LeaseTimes& times);
    ~LeaseKeeper();
    LeaseKeeper(const LeaseKeeper&) = delete;
    LeaseKeeper& operator=(const LeaseKeeper&) = delete;

    bool lost() const { return lost_; }
    bool cancel_requested() const { return cancel_requested_; }

private:
    void run(const std::stop_token& stop);
    void ask();

    LeaseCalls calls_;
    LeaseTimes times_;
    std::chrono::steady_clock::time_point renewed_ = std::chrono::steady_clock::now();
    std::atomic<bool> lost_ = false;
    std::atomic<bool> cancel_requested_ = false;
    std::mutex mutex_;
    std::condition_variable_any wake_;
    std::jthread thread_;  // last: it uses the members above
};

}  // namespace divemesh::runner
