#include "tests/end_to_end/process.hpp"

#include <atomic>
#include <fcntl.h>
#include <fstream>
#include <signal.h>
#include <spawn.h>
#include <sstream>
#include <stdexcept>
#include <sys/wait.h>
#include <thread>
#include <unistd.h>
#include <utility>

namespace divemesh {
namespace {

std::vector<char*> pointers(std::vector<std::string>& texts) {
    std::vector<char*> result;
    for (auto& text : texts) result.push_back(text.data());
    result.push_back(nullptr);
    return result;
}

std::vector<std::string> merged(const Process::Environment& added) {
    std::vector<std::string> result;
    for (char** entry = environ; *entry != nullptr; ++entry) {
        const std::string text = *entry;
        if (!added.contains(text.substr(0, text.find('=')))) result.push_back(text);
    }
    for (const auto& [name, value] : added) result.push_back(name + "=" + value);
    return result;
}

}  // namespace

Process::Process(const std::vector<std::string>& command,
                 const std::filesystem::path& output_folder,
                 const Environment& environment) {
    static std::atomic<int> num_started{0};
    const std::string name = "process" + std::to_string(num_started++);
    stdout_file_ = output_folder / (name + ".out");
    stderr_file_ = output_folder / (name + ".err");
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    const int flags = O_WRONLY | O_CREAT | O_TRUNC;
    posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
    posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, stdout_file_.c_str(), flags, 0600);
    posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, stderr_file_.c_str(), flags, 0600);
    std::vector<std::string> arguments = command;
    std::vector<std::string> variables = merged(environment);
    const int failure = ::posix_spawn(&pid_,
                                      command.front().c_str(),
                                      &actions,
                                      nullptr,
                                      pointers(arguments).data(),
                                      pointers(variables).data());
    posix_spawn_file_actions_destroy(&actions);
    if (failure != 0) throw std::runtime_error("cannot start " + command.front());
}

Process::~Process() {
    if (pid_ > 0 && !exit_code_) kill();
}

Process::Process(Process&& other) noexcept
    : pid_(std::exchange(other.pid_, -1)),
      exit_code_(other.exit_code_),
      stdout_file_(std::move(other.stdout_file_)),
      stderr_file_(std::move(other.stderr_file_)) {}

std::optional<int> Process::wait(std::chrono::seconds timeout) {
    wait_until(timeout, [&] {
        if (exit_code_) return true;
        int status = 0;
        if (::waitpid(pid_, &status, WNOHANG) != pid_) return false;
        exit_code_ = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
        return true;
    });
    return exit_code_;
}

void Process::send(int signal) {
    if (!exit_code_) ::kill(pid_, signal);
}

void Process::kill() {
    send(SIGKILL);
    wait(std::chrono::seconds(10));
}

std::string Process::stdout_text() const { return read_text(stdout_file_); }
std::string Process::stderr_text() const { return read_text(stderr_file_); }

std::string read_text(const std::filesystem::path& file) {
    std::ifstream stream(file, std::ios::binary);
    std::ostringstream text;
    text << stream.rdbuf();
    return text.str();
}

void pause_20_ms() { std::this_thread::sleep_for(std::chrono::milliseconds(20)); }

}  // namespace divemesh
