#pragma once

#include <chrono>
#include <functional>
#include <random>
#include <stop_token>
#include <string>

#include "schemas/error.hpp"

namespace divemesh::api::client {

// Waits between tries. The wait doubles from 0.1 s to 30 s and is shortened at random, so that many
// clients do not come back at the same time. Gives up after `give_up_after` without progress; zero:
// never.
class Backoff {
public:
    using OnWait = std::function<void(const Error& reason, std::chrono::milliseconds pause)>;

    Backoff(std::chrono::milliseconds give_up_after, OnWait on_wait, std::stop_token stop = {});

    void moved();  // resets the wait after progress
    // Sleeps. Throws `reason` when the time is up, and Error{Cancelled} when stop is requested.
    void wait(const Error& reason);

    // Returns what `work` returns. Retries it as long as it throws Error{Unavailable}.
    template <typename Work>
    auto until_done(const Work& work) {
        while (true) {
            try {
                return work();
            } catch (const Error& error) {
                if (error.code() != ErrorCode::Unavailable) throw;
                wait(error);
            }
        }
    }

private:
    std::chrono::milliseconds give_up_after_;
    OnWait on_wait_;
    std::stop_token stop_;
    std::chrono::steady_clock::time_point last_moved_;
    int num_tries_ = 0;
    std::mt19937 random_{std::random_device{}()};
};

}  // namespace divemesh::api::client
