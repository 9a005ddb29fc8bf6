#include <cstdlib>

#include "tests/fuzz/input.hpp"
#include "tests/portless_service.hpp"

namespace {

constexpr std::string_view kUpgrade =
    "GET /api/v1/sensors/aqua/stream HTTP/1.1\r\nHost: a\r\nConnection: Upgrade\r\n"
    "Upgrade: websocket\r\nSec-WebSocket-Version: 13\r\n"
    "Sec-WebSocket-Key: AAECAwQFBgcICQoLDA0ODw==\r\n\r\n";

// A whole message of a client, masked with zeros (RFC 6455, 5.2).
std::string message_of(std::string_view payload, bool is_binary) {
    std::string frame(1, is_binary ? '\x82' : '\x81');
    frame += '\xFF';
    for (int shift = 56; shift >= 0; shift -= 8)
        frame += static_cast<char>(payload.size() >> shift & 0xFFU);
    return frame.append(4, '\0').append(payload);
}

}  // namespace

// What a sensor says: lines that are reports, and after an empty line one preview.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    static divemesh::PortlessService service;
    divemesh::fuzz::Input input(data, size);
    std::string frames;
    for (auto line = input.line(); !line.empty(); line = input.line())
        frames += message_of(line, false);
    if (!input.empty()) frames += message_of(input.rest(), true);
    const auto heard = service.converse(std::string(kUpgrade) + frames);
    if (!heard.starts_with("HTTP/1.1 101 ") || heard.find("welcome") == std::string::npos)
        std::abort();
    return 0;
}
