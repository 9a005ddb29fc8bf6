#pragma once

#include <stop_token>
#include <thread>

namespace divemesh::cli {

// SIGTERM and SIGINT as a stop token. Create it before any other thread, so that the others leave
// the signals to its thread.
class StopSignal {
public:
    StopSignal();
    ~StopSignal();
    StopSignal(const StopSignal&) = delete;
    StopSignal& operator=(const StopSignal&) = delete;

    std::stop_token token() const { return source_.get_token(); }

private:
    std::stop_source source_;
    std::jthread waiter_;
};

}  // namespace divemesh::cli
