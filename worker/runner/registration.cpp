#include "worker/runner/registration.hpp"

#include <chrono>

#include "schemas/log.hpp"

namespace divemesh::runner {
namespace {

constexpr auto kReportEvery = std::chrono::seconds(5);

}  // namespace

Registration::Registration(storage::Catalog& catalog, std::string name, int num_slots)
    : workers_(catalog), name_(std::move(name)), num_slots_(num_slots) {
    workers_.report(name_, num_slots_);
    thread_ = std::jthread([this](const std::stop_token& stop) { run(stop); });
}

Registration::~Registration() {
    thread_.request_stop();
    thread_.join();
    try {
        workers_.remove(name_);
    } catch (const std::exception& error) {
        log_warning({{"event", "not_registered"}, {"what", error.what()}});
    }
}

void Registration::set_waits_for(const std::string& reason) {
    const std::lock_guard lock(mutex_);
    waits_for_ = reason;
    if (waits_for_ != reported_) changed_.notify_one();
}

void Registration::run(const std::stop_token& stop) {
    while (!stop.stop_requested()) {
        std::string reason;
        {
            std::unique_lock lock(mutex_);
            changed_.wait_for(lock, stop, kReportEvery, [this] { return waits_for_ != reported_; });
            if (stop.stop_requested()) return;
            reason = reported_ = waits_for_;
        }
        try {
            workers_.report(name_, num_slots_, reason);
        } catch (const std::exception& error) {
            log_warning({{"event", "not_registered"}, {"what", error.what()}});
        }
    }
}

}  // namespace divemesh::runner
