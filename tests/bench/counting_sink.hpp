#pragma once

#include <atomic>
#include <thread>

#include "schemas/file_descriptor.hpp"

namespace divemesh::bench {

// An HTTP server that counts and discards the bytes of a body: the upper limit of the rate that
// network and client allow. It serves one connection at a time, on a free port.
class CountingSink {
public:
    CountingSink();
    ~CountingSink();
    CountingSink(const CountingSink&) = delete;
    CountingSink& operator=(const CountingSink&) = delete;

    int port() const { return port_; }

private:
    void serve();

    FileDescriptor listener_;
    int port_ = 0;
    std::atomic<bool> stop_ = false;
    std::thread thread_;
};

}  // namespace divemesh::bench
