#pragma once

#include <atomic>
#include <thread>

namespace divemesh::bench {

// An HTTP server that counts the bytes of a body and forgets them: what the network and the client
// leave room for. One connection at a time, on a port of its own.
class CountingSink {
public:
    CountingSink();
    ~CountingSink();
    CountingSink(const CountingSink&) = delete;
    CountingSink& operator=(const CountingSink&) = delete;

    int port() const { return port_; }

private:
    void serve();

    int listener_ = -1;
    int port_ = 0;
    std::atomic<bool> stop_ = false;
    std::thread thread_;
};

}  // namespace divemesh::bench
