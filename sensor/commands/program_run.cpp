#include "sensor/commands/program_run.hpp"

#include <csignal>
#include <spawn.h>
#include <sys/wait.h>
#include <system_error>
#include <unistd.h>

#include "schemas/error.hpp"

namespace divemesh::sensor {

ProgramRun::ProgramRun(const std::vector<std::string>& command, std::chrono::milliseconds time)
    : until_(Clock::now() + time) {
    std::vector<char*> words;
    words.reserve(command.size() + 1);
    for (const std::string& word : command) words.push_back(const_cast<char*>(word.c_str()));
    words.push_back(nullptr);
    posix_spawnattr_t attributes;
    posix_spawnattr_init(&attributes);
    sigset_t none;
    sigemptyset(&none);
    posix_spawnattr_setsigmask(&attributes, &none);  // the agent blocks some signals
    sigset_t usual;
    sigemptyset(&usual);
    sigaddset(&usual, SIGPIPE);
    sigaddset(&usual, SIGXFSZ);
    posix_spawnattr_setsigdefault(&attributes, &usual);
    posix_spawnattr_setpgroup(&attributes, 0);
    posix_spawnattr_setflags(
        &attributes, POSIX_SPAWN_SETPGROUP | POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF);
    const int failure = posix_spawnp(&pid_, words[0], nullptr, &attributes, words.data(), environ);
    posix_spawnattr_destroy(&attributes);
    if (failure == 0) return;
    pid_ = -1;
    throw Error(ErrorCode::Unavailable,
                "cannot start " + command[0] + ": " + std::generic_category().message(failure));
}

ProgramRun::~ProgramRun() { kill_group(); }

void ProgramRun::kill_group() {
    if (pid_ <= 0) return;
    ::kill(-pid_, SIGKILL);
    ::waitpid(pid_, nullptr, 0);
    pid_ = -1;
}

std::optional<std::string> ProgramRun::poll() {
    if (pid_ <= 0) return "it has ended";
    int status = 0;
    const pid_t ended = ::waitpid(pid_, &status, WNOHANG);
    if (ended == 0 && Clock::now() < until_) return std::nullopt;
    if (ended == 0) {
        kill_group();
        return "it took too long and was ended";
    }
    pid_ = -1;
    if (ended < 0) return "it is not known how it ended";
    if (WIFEXITED(status) && WEXITSTATUS(status) == 0) return "";
    if (WIFEXITED(status)) return "it ended with exit code " + std::to_string(WEXITSTATUS(status));
    return "it was ended by signal " + std::to_string(WTERMSIG(status));
}

}  // namespace divemesh::sensor
