#pragma once

#include <chrono>
#include <functional>
#include <random>
#include <string>

#include "schemas/error.hpp"

namespace divemesh::api::client {

// Waits between tries: doubling from half a second to half a minute, shortened at random so that
// many clients do not come back together. Gives up when nothing has moved for `give_up_after`.
class Backoff {
public:
    using OnWait = std::function<void(const Error& reason, std::chrono::milliseconds pause)>;

    Backoff(std::chrono::milliseconds give_up_after, OnWait on_wait);

    void moved();                    // something got through: start over
    void wait(const Error& reason);  // sleeps; throws `reason` when the time is up

private:
    std::chrono::milliseconds give_up_after_;
    OnWait on_wait_;
    std::chrono::steady_clock::time_point last_moved_;
    int num_tries_ = 0;
    std::mt19937 random_{std::random_device{}()};
};

}  // namespace divemesh::api::client
