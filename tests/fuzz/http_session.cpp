#include <cstdlib>

#include "tests/fuzz/input.hpp"
#include "tests/portless_service.hpp"

// Fuzzes the bytes that a client sends to the port.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    static divemesh::PortlessService service;
    const auto heard = service.converse(divemesh::fuzz::Input(data, size).rest());
    if (heard.find("HTTP/1.1 500 ") != std::string::npos) std::abort();
    return 0;
}
