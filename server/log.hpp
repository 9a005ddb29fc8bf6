#pragma once

namespace divemesh::server {

// Sends log messages from now on to stderr, each line with its time and level.
void start_log();

}  // namespace divemesh::server
