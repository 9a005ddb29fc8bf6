#pragma once

namespace divemesh::server {

// Sends what is logged from here on to stderr, each line with its time and level.
void start_log();

}  // namespace divemesh::server
