// serve_process DATA [LIMIT_BYTES]: a server as a process of its own, so that tests can kill it or
// have its disk full (no file may grow past LIMIT_BYTES).
#include <cstdlib>
#include <iostream>
#include <sys/resource.h>

#include "server/server.hpp"

int main(int argc, char** argv) {
    if (argc < 2) return 2;
    if (argc > 2) {
        const rlim_t limit = std::strtoull(argv[2], nullptr, 10);
        const rlimit both{limit, limit};
        if (setrlimit(RLIMIT_FSIZE, &both) != 0) return 2;
    }
    divemesh::server::ServerConfig config;
    config.listen = "127.0.0.1:0";
    config.data = argv[1];
    config.min_free_bytes = 0;
    try {
        divemesh::server::run_server(config);
        return 0;
    } catch (const std::exception& error) {
        std::cerr << error.what() << '\n';
        return 1;
    }
}
