#include "tests/bench/bench_main.hpp"

#include <csignal>
#include <exception>
#include <iostream>
#include <sys/resource.h>

namespace divemesh {

void prepare_for_many_connections() {
    std::signal(SIGPIPE, SIG_IGN);
    rlimit files{};
    getrlimit(RLIMIT_NOFILE, &files);
    files.rlim_cur = files.rlim_max;
    setrlimit(RLIMIT_NOFILE, &files);
}

int run_or_say_why(int (*run)(int argc, char** argv), int argc, char** argv) {
    try {
        return run(argc, argv);
    } catch (const std::exception& error) {
        std::cerr << error.what() << '\n';
        return 1;
    }
}

}  // namespace divemesh
