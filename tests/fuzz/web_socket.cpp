#include <cstdlib>

#include "tests/fuzz/input.hpp"
#include "tests/portless_service.hpp"

namespace {

constexpr std::string_view kUpgrade =
    "GET /api/v1/events HTTP/1.1\r\nHost: a\r\nConnection: Upgrade\r\nUpgrade: websocket\r\n"
    "Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: AAECAwQFBgcICQoLDA0ODw==\r\n\r\n";

}  // namespace

// Frames that a client sends on an event stream, after a handshake that is as it should be.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    static divemesh::PortlessService service;
    const auto frames = divemesh::fuzz::Input(data, size).rest();
    const auto heard = service.converse(std::string(kUpgrade) + std::string(frames));
    if (!heard.starts_with("HTTP/1.1 101 ")) std::abort();
    return 0;
}
