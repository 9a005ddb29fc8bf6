#pragma once

#include <cstdint>
#include <memory>

namespace divemesh {

// What a bad link does to the connection on which the client's last of `cut_after_bytes` came.
enum class Cut {
    Reset,     // both sides are reset
    HalfOpen,  // the client is reset, the server hears nothing any more: wifi that was left
    Stall,     // nothing passes any more, and nobody is told
};

struct BadLink {
    Cut cut = Cut::Reset;
    // Counted from the cut before over all connections, for a client that opens one for each
    // request is to be cut as well.
    std::int64_t cut_after_bytes = std::int64_t{10} << 20;
    int num_cuts = 1000;       // then it is a good link
    double bytes_per_s = 0.0;  // 0: as fast as it goes
};

// A TCP proxy on a port of loopback of its own that behaves as a bad link to `target_port`.
class FlakyProxy {
public:
    FlakyProxy(int target_port, const BadLink& link);
    ~FlakyProxy();
    FlakyProxy(const FlakyProxy&) = delete;
    FlakyProxy& operator=(const FlakyProxy&) = delete;

    int port() const;
    int num_cuts() const;
    int num_connections() const;
    std::int64_t num_bytes() const;  // that the client sent, what was dropped at a cut included

private:
    struct Implementation;
    std::unique_ptr<Implementation> implementation_;
};

}  // namespace divemesh
