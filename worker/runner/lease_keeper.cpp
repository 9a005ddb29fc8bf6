#include "worker/runner/lease_keeper.hpp"

#include <algorithm>
#include <exception>

#include "schemas/log.hpp"

namespace divemesh::runner {

LeaseKeeper::LeaseKeeper(LeaseCalls calls, const LeaseTimes& times)
    : calls_(std::move(calls)),
      times_(times),
      thread_([this](const std::stop_token& stop) { run(stop); }) {}

LeaseKeeper::~LeaseKeeper() {
    thread_.request_stop();
    thread_.join();
}

void LeaseKeeper::run(const std::stop_token& stop) {
    while (!stop.stop_requested() && !lost_) {
        std::unique_lock lock(mutex_);
        wake_.wait_for(
            lock, stop, std::min(times_.check_every, times_.renew_every), [] { return false; });
        if (!stop.stop_requested()) ask();
    }
}

void LeaseKeeper::ask() {
    const auto now = std::chrono::steady_clock::now();
    const bool due = now - renewed_ >= times_.renew_every;
    try {
        const LeaseStatus status = due ? calls_.renew() : calls_.check_lease();
        if (status == LeaseStatus::Lost) lost_ = true;
        if (status == LeaseStatus::CancelRequested) cancel_requested_ = true;
        if (due) renewed_ = now;
    } catch (const std::exception& error) {
        log_warning({{"event", "lease_not_renewed"}, {"what", error.what()}});
        if (std::chrono::steady_clock::now() - renewed_ > times_.lease) lost_ = true;
    }
}

}  // namespace divemesh::runner
