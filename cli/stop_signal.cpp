#include "cli/stop_signal.hpp"

#include <csignal>
#include <ctime>

namespace divemesh::cli {
namespace {

sigset_t stop_signals() {
    sigset_t signals;
    sigemptyset(&signals);
    sigaddset(&signals, SIGTERM);
    sigaddset(&signals, SIGINT);
    return signals;
}

}  // namespace

StopSignal::StopSignal() {
    const sigset_t signals = stop_signals();
    pthread_sigmask(SIG_BLOCK, &signals, nullptr);
    waiter_ = std::jthread([this](const std::stop_token& end) {
        const sigset_t awaited = stop_signals();
        const timespec pause{0, 100'000'000};
        while (!end.stop_requested())
            if (sigtimedwait(&awaited, nullptr, &pause) > 0) source_.request_stop();
    });
}

StopSignal::~StopSignal() {
    waiter_.request_stop();
    waiter_.join();
    const sigset_t signals = stop_signals();
    pthread_sigmask(SIG_UNBLOCK, &signals, nullptr);
}

}  // namespace divemesh::cli
