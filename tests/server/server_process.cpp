#include "tests/server/server_process.hpp"

#include <csignal>
#include <fstream>
#include <stdexcept>
#include <sys/wait.h>
#include <unistd.h>

namespace divemesh {

ServerProcess::ServerProcess(const std::filesystem::path& data,
                             const std::vector<std::string>& more) {
    std::vector<std::string> words = {"serve_process", data.string()};
    words.insert(words.end(), more.begin(), more.end());
    std::vector<char*> arguments;
    for (std::string& word : words) arguments.push_back(word.data());
    arguments.push_back(nullptr);
    int out[2];
    if (pipe(out) != 0) throw std::runtime_error("pipe");
    pid_ = fork();
    if (pid_ == 0) {
        dup2(out[1], STDOUT_FILENO);
        close(out[0]);
        close(out[1]);
        execv(DIVEMESH_SERVE_PROCESS, arguments.data());
        _exit(127);
    }
    close(out[1]);
    std::string line;
    for (char c = 0; read(out[0], &c, 1) == 1 && c != '\n';) line += c;
    close(out[0]);
    if (line.empty()) throw std::runtime_error("the server did not start");
    port_ = std::stoi(line.substr(line.rfind(':') + 1));
}

ServerProcess::~ServerProcess() { end(SIGKILL); }

void ServerProcess::send(int signal) const { kill(pid_, signal); }

int ServerProcess::end(int signal) {
    if (pid_ <= 0) return -1;
    kill(pid_, signal);
    int status = 0;
    waitpid(pid_, &status, 0);
    pid_ = -1;
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

std::string read_token(const std::filesystem::path& data) {
    std::ifstream file(data / "admin.token");
    std::string token;
    file >> token;
    return token;
}

}  // namespace divemesh
