#include "cli/interrupt.hpp"

#include <csignal>

#include "schemas/error.hpp"

namespace divemesh::cli {
namespace {

volatile std::sig_atomic_t interrupted = 0;

void on_signal(int signal) {
    interrupted = 1;
    std::signal(signal, SIG_DFL);
}

}  // namespace

void catch_interrupts() {
    std::signal(SIGINT, on_signal);
    std::signal(SIGTERM, on_signal);
}

void throw_if_interrupted() {
    if (interrupted != 0) throw Error(ErrorCode::Cancelled, "interrupted");
}

}  // namespace divemesh::cli
