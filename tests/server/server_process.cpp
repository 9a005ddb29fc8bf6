#include "tests/server/server_process.hpp"

#include <csignal>
#include <fstream>
#include <stdexcept>
#include <sys/wait.h>
#include <unistd.h>

#include "schemas/file_descriptor.hpp"

namespace divemesh {

ServerProcess::ServerProcess(const std::filesystem::path& data,
                             const std::vector<std::string>& more) {
    std::vector<std::string> words = {"serve_process", data.string()};
    words.insert(words.end(), more.begin(), more.end());
    std::vector<char*> arguments;
    for (std::string& word : words) arguments.push_back(word.data());
    arguments.push_back(nullptr);
    int ends[2];
    if (pipe(ends) != 0) throw std::runtime_error("pipe");
    FileDescriptor read_end(ends[0]);
    FileDescriptor write_end(ends[1]);
    pid_ = fork();
    if (pid_ == 0) {
        dup2(write_end.get(), STDOUT_FILENO);
        read_end.close();
        write_end.close();
        execv(DIVEMESH_SERVE_PROCESS, arguments.data());
        _exit(127);
    }
    write_end.close();
    std::string line;
    for (char c = 0; read(read_end.get(), &c, 1) == 1 && c != '\n';) line += c;
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
