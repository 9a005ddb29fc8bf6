#include "api/client/backoff.hpp"

#include <algorithm>
#include <thread>

namespace divemesh::api::client {
namespace {

constexpr std::chrono::milliseconds kFirstPause{500};
constexpr std::chrono::milliseconds kLongestPause{30'000};

}  // namespace

Backoff::Backoff(std::chrono::milliseconds give_up_after, OnWait on_wait)
    : give_up_after_(give_up_after),
      on_wait_(std::move(on_wait)),
      last_moved_(std::chrono::steady_clock::now()) {}

void Backoff::moved() {
    last_moved_ = std::chrono::steady_clock::now();
    num_tries_ = 0;
}

void Backoff::wait(const Error& reason) {
    const auto idle = std::chrono::steady_clock::now() - last_moved_;
    if (idle >= give_up_after_) throw reason;
    const auto longest = std::min(kLongestPause, kFirstPause * (1 << std::min(num_tries_, 6)));
    ++num_tries_;
    std::uniform_int_distribution<std::int64_t> jitter(longest.count() / 2, longest.count());
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(give_up_after_ - idle);
    const auto pause = std::min(std::chrono::milliseconds(jitter(random_)), left);
    if (on_wait_) on_wait_(reason, pause);
    std::this_thread::sleep_for(pause);
}

}  // namespace divemesh::api::client
