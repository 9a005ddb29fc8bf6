#pragma once

#include <cstdint>
#include <memory>

namespace divemesh {

// What a bad link does to the connection over which the limit of `cut_after_bytes` is passed.
enum class Cut {
    Reset,     // both sides are reset
    HalfOpen,  // the client is reset and the server receives nothing more, like lost Wi-Fi
    Stall,     // both sides stay open and receive nothing more
};

struct BadLink {
    Cut cut = Cut::Reset;
    // Counts bytes of the client since the last cut, over all connections. So a client that opens a
    // connection for each request is cut too.
    std::int64_t cut_after_bytes = std::int64_t{10} << 20;
    int num_cuts = 1000;       // after these the link is good
    double bytes_per_s = 0.0;  // from the client; 0: without a limit
};

// A TCP proxy on a free port of loopback that behaves like a bad link to `target_port`.
class FlakyProxy {
public:
    FlakyProxy(int target_port, const BadLink& link);
    ~FlakyProxy();
    FlakyProxy(const FlakyProxy&) = delete;
    FlakyProxy& operator=(const FlakyProxy&) = delete;

    int port() const;
    int num_cuts() const;
    int num_connections() const;
    std::int64_t num_bytes() const;  // received from the client, including those dropped at a cut

private:
    struct Implementation;
    std::unique_ptr<Implementation> implementation_;
};

}  // namespace divemesh
