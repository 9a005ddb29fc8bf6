#include "cli/server_process.hpp"

#include <cerrno>
#include <csignal>
#include <cstring>
#include <fcntl.h>
#include <linux/close_range.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>
#include <vector>

#include "schemas/error.hpp"
#include "schemas/file_descriptor.hpp"

namespace divemesh::cli {
namespace {

namespace fs = std::filesystem;

Error failure(const std::string& what) {
    return {ErrorCode::Unavailable, what + ": " + std::strerror(errno)};
}

std::vector<std::string> command(const fs::path& data) {
    return {"/proc/self/exe",
            "--config",
            "/dev/null",
            "serve",
            "--data",
            data.string(),
            "--listen",
            "127.0.0.1:0",
            "--workers",
            "1"};
}

// Returns this process's environment without what configures divemesh.
std::vector<std::string> plain_environment() {
    std::vector<std::string> variables;
    for (char** variable = environ; *variable != nullptr; ++variable)
        if (!std::string_view(*variable).starts_with("DIVEMESH_")) variables.push_back(*variable);
    return variables;
}

std::vector<char*> pointers_to(std::vector<std::string>& texts) {
    std::vector<char*> pointers;
    pointers.reserve(texts.size() + 1);
    for (std::string& text : texts) pointers.push_back(text.data());
    pointers.push_back(nullptr);
    return pointers;
}

// Runs between fork and exec in a process with threads, so only async-signal-safe calls are
// allowed.
[[noreturn]] void become(
    char* const* arguments, char* const* variables, int output, int log, pid_t parent) {
    prctl(PR_SET_PDEATHSIG, SIGTERM);
    if (getppid() != parent) _exit(127);  // the parent ended before the line above
    dup2(open("/dev/null", O_RDONLY), STDIN_FILENO);
    dup2(output, STDOUT_FILENO);
    dup2(log, STDERR_FILENO);
    close_range(STDERR_FILENO + 1, ~0U, CLOSE_RANGE_CLOEXEC);
    execve(arguments[0], arguments, variables);
    _exit(127);
}

// Returns the first line that comes, without its end; what there is of it if it breaks off.
std::string read_line(int input) {
    std::string line;
    for (char byte = 0;;) {
        const auto n = read(input, &byte, 1);
        if (n < 0 && errno == EINTR) continue;
        if (n <= 0 || byte == '\n') return line;
        line += byte;
    }
}

}  // namespace

ServerProcess::ServerProcess(const fs::path& data, const fs::path& log) {
    const FileDescriptor log_file(
        open(log.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0600));
    if (!log_file.is_open()) throw failure("cannot write " + log.string());
    int ends[2];
    if (pipe2(ends, O_CLOEXEC) != 0) throw failure("pipe");
    const FileDescriptor output(ends[0]);
    FileDescriptor childs_end(ends[1]);
    auto words = command(data);
    auto variables = plain_environment();
    const auto arguments = pointers_to(words);
    const auto environment = pointers_to(variables);
    const pid_t parent = getpid();
    pid_ = fork();
    if (pid_ == 0)
        become(arguments.data(), environment.data(), childs_end.get(), log_file.get(), parent);
    if (pid_ < 0) throw failure("fork");
    childs_end.close();
    const std::string said = "listening on ";
    const std::string line = read_line(output.get());
    if (line.starts_with(said)) {
        url_ = line.substr(said.size());
        return;
    }
    wait();
    throw Error(ErrorCode::Unavailable, "the server did not start: see " + log.string());
}

ServerProcess::~ServerProcess() {
    if (pid_ > 0) kill(pid_, SIGTERM);
    wait();
}

void ServerProcess::wait() {
    int status = 0;
    while (pid_ > 0 && waitpid(pid_, &status, 0) < 0 && errno == EINTR) {
    }
    pid_ = -1;
}

}  // namespace divemesh::cli
