#include "api/client/backoff.hpp"

#include <algorithm>
#include <condition_variable>
#include <mutex>

namespace divemesh::api::client {
namespace {

using std::chrono::milliseconds;

constexpr milliseconds kFirstPause{100};
constexpr milliseconds kMaxPause{30'000};
constexpr int kMaxDoublings = 9;

void sleep_for(milliseconds pause, const std::stop_token& stop) {
    std::mutex mutex;
    std::unique_lock lock(mutex);
    std::condition_variable_any never;
    never.wait_for(lock, stop, pause, [] { return false; });
    if (stop.stop_requested()) throw Error(ErrorCode::Cancelled, "stopped while waiting");
}

}  // namespace

Backoff::Backoff(milliseconds give_up_after, OnWait on_wait, std::stop_token stop)
    : give_up_after_(give_up_after),
      on_wait_(std::move(on_wait)),
      stop_(std::move(stop)),
      last_moved_(std::chrono::steady_clock::now()) {}

void Backoff::moved() {
    last_moved_ = std::chrono::steady_clock::now();
    num_tries_ = 0;
}

void Backoff::wait(const Error& reason) {
    const auto idle = std::chrono::steady_clock::now() - last_moved_;
    const bool gives_up = give_up_after_ > milliseconds(0);
    if (gives_up && idle >= give_up_after_) throw reason;
    const auto longest =
        std::min(kMaxPause, kFirstPause * (1 << std::min(num_tries_, kMaxDoublings)));
    ++num_tries_;
    std::uniform_int_distribution<std::int64_t> jitter(longest.count() / 2, longest.count());
    milliseconds pause(jitter(random_));
    if (gives_up)
        pause = std::min(pause, std::chrono::duration_cast<milliseconds>(give_up_after_ - idle));
    if (on_wait_) on_wait_(reason, pause);
    sleep_for(pause, stop_);
}

}  // namespace divemesh::api::client
