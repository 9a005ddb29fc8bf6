#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <thread>

namespace divemesh::runner {

// What renewing a lease brought back.
enum class LeaseStatus { Valid, CancelRequested, Lost };

// How a lease is asked about. Both functions are called from the keeper's thread.
struct LeaseCalls {
    std::function<LeaseStatus()> renew;
    std::function<LeaseStatus()> look;  // without renewing: cheap, brings a cancel request soon
};

struct LeaseTimes {
    std::chrono::milliseconds lease;
    std::chrono::milliseconds renew_every;
    std::chrono::milliseconds check_every;
};

// Renews a lease by timer from a thread of its own, so that neither a slow disk nor a busy child
// lets it expire. When renewing fails for as long as the lease lasts (the catalog is out of reach),
// the lease counts as lost.
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
    std::jthread thread_;  // last: it uses the others
};

}  // namespace divemesh::runner
