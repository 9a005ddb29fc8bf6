#pragma once

#include <string>
#include <string_view>

#include "schemas/file_descriptor.hpp"

namespace divemesh {

// Plain blocking sockets for load generators. All functions throw std::runtime_error on failure,
// except receive_head().

// Returns a socket connected to a port of loopback. With `receive_buffer_bytes` 0 the kernel
// chooses the size of the receive buffer.
FileDescriptor connect_to(int port, int receive_buffer_bytes);
// Returns a port of loopback that was free during the call.
int free_port();
void send_all(int socket, std::string_view bytes);
// Reads the head of a response up to and including the empty line. Returns the bytes received so
// far if the peer closes before.
std::string receive_head(int socket);
// Sends a WebSocket handshake. Throws if the answer is not 101.
void open_web_socket(int socket, const std::string& target, const std::string& token);

}  // namespace divemesh
