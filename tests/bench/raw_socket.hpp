#pragma once

#include <string>
#include <string_view>

namespace divemesh {

// Sockets as load generators use them: nothing between them and the kernel. What fails throws
// std::runtime_error.

// To loopback; `receive_buffer_bytes` 0: as the kernel likes.
int connect_to(int port, int receive_buffer_bytes);
int free_port();  // of loopback, that was free a moment ago
void send_all(int socket, std::string_view bytes);
// Up to the empty line; what came when the other end closed before.
std::string receive_head(int socket);
// The head of a request for a WebSocket, answered by 101.
void open_web_socket(int socket, const std::string& target, const std::string& token);

}  // namespace divemesh
