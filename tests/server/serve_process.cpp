// serve_process DATA [LIMIT_BYTES [KILL_AT]]: a server as a process of its own, so that tests can
// kill it, have its disk full (no file may grow past LIMIT_BYTES; 0: as they may here), or have it
// killed at the fault point with the number KILL_AT after SIGUSR1.
#include <csignal>
#include <cstdlib>
#include <iostream>
#include <sys/resource.h>

#include "server/server.hpp"
#include "storage/fault_point.hpp"

namespace {

int kill_at = 0;

#ifdef DIVEMESH_FAULT_POINTS
void count_from_now(int) { divemesh::storage::kill_at_fault_point(kill_at); }
#endif

}  // namespace

int main(int argc, char** argv) {
    if (argc < 2) return 2;
    const rlim_t limit = argc > 2 ? std::strtoull(argv[2], nullptr, 10) : 0;
    const rlimit both{limit, limit};
    if (limit > 0 && setrlimit(RLIMIT_FSIZE, &both) != 0) return 2;
    if (argc > 3) kill_at = std::atoi(argv[3]);
#ifdef DIVEMESH_FAULT_POINTS
    std::signal(SIGUSR1, count_from_now);
#else
    if (kill_at > 0) return 2;
#endif
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
