#include "tests/bench/program.hpp"

#include <cerrno>
#include <chrono>
#include <fcntl.h>
#include <fstream>
#include <iterator>
#include <spawn.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

extern char** environ;

namespace divemesh::bench {
namespace {

// Runs it to its end; `usage` is of the program alone.
int run(std::vector<std::string> words,
        const std::filesystem::path& log,
        bool errors_apart,
        rusage& usage) {
    std::vector<char*> arguments;
    for (std::string& word : words) arguments.push_back(word.data());
    arguments.push_back(nullptr);
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_addopen(
        &actions, STDOUT_FILENO, log.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644);
    if (!errors_apart) posix_spawn_file_actions_adddup2(&actions, STDOUT_FILENO, STDERR_FILENO);
    pid_t child = 0;
    const int failure =
        posix_spawn(&child, arguments[0], &actions, nullptr, arguments.data(), environ);
    posix_spawn_file_actions_destroy(&actions);
    if (failure != 0) return 127;
    int status = 0;
    while (wait4(child, &status, 0, &usage) < 0 && errno == EINTR) {
    }
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128;
}

double seconds(const timeval& time) {
    return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
}

}  // namespace

int run_program(std::vector<std::string> words,
                const std::filesystem::path& log,
                bool errors_apart) {
    rusage usage{};
    return run(std::move(words), log, errors_apart, usage);
}

ProgramUsage run_measured(std::vector<std::string> words, const std::filesystem::path& log) {
    rusage usage{};
    const auto start = std::chrono::steady_clock::now();
    ProgramUsage result;
    result.exit_code = run(std::move(words), log, false, usage);
    result.wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    result.cpu_s = seconds(usage.ru_utime) + seconds(usage.ru_stime);
    result.peak_memory_bytes = 1024 * std::int64_t{usage.ru_maxrss};
    return result;
}

std::string last_lines(const std::filesystem::path& log) {
    std::ifstream stream(log);
    const std::string text{std::istreambuf_iterator<char>(stream), {}};
    return text.size() > 600 ? text.substr(text.size() - 600) : text;
}

}  // namespace divemesh::bench
