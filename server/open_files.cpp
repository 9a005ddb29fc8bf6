#include "server/open_files.hpp"

#include <algorithm>
#include <cstdint>
#include <sys/resource.h>

#include "schemas/log.hpp"

namespace divemesh::server {
namespace {

constexpr rlim_t kFilesPerConnection = 2;  // the socket, and the file that it sends or receives
constexpr rlim_t kFilesBeside = 200;       // catalog connections, pipes of workers, log
constexpr rlim_t kMinConnections = 16;

}  // namespace

int raise_open_files(int num_connections) {
    rlimit files{};
    if (getrlimit(RLIMIT_NOFILE, &files) != 0) return num_connections;
    const rlim_t needed =
        kFilesBeside + kFilesPerConnection * static_cast<rlim_t>(std::max(num_connections, 1));
    if (files.rlim_cur >= needed) return num_connections;
    const rlimit raised{std::min(needed, files.rlim_max), files.rlim_max};
    if (setrlimit(RLIMIT_NOFILE, &raised) == 0) files = raised;
    if (files.rlim_cur >= needed) return num_connections;
    const rlim_t left = files.rlim_cur - std::min(files.rlim_cur, kFilesBeside);
    const int fitting = static_cast<int>(std::max(left / kFilesPerConnection, kMinConnections));
    log_warning({{"event", "few_open_files"},
                 {"limit", static_cast<std::uint64_t>(files.rlim_cur)},
                 {"needed", static_cast<std::uint64_t>(needed)},
                 {"max_connections", std::min(fitting, num_connections)},
                 {"what",
                  "the limit of open files is too low for --max-connections: raise the hard limit "
                  "(LimitNOFILE= of systemd, ulimit -Hn), or lower --max-connections"}});
    return std::min(fitting, num_connections);
}

}  // namespace divemesh::server
