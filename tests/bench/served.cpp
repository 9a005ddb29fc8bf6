#include "tests/bench/served.hpp"

#include <chrono>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <unistd.h>

namespace divemesh {

using namespace std::chrono_literals;

Served::Served(const std::filesystem::path& program, const std::filesystem::path& data)
    : process_({program.string(),
                "serve",
                "--data",
                data.string(),
                "--listen",
                "127.0.0.1:0",
                "--workers",
                "0"},
               data.parent_path()) {
    const std::string mark = "listening on ";
    const bool up =
        wait_until(60s, [&] { return process_.stdout_text().find('\n') != std::string::npos; });
    const std::string text = process_.stdout_text();
    if (!up || !text.starts_with(mark)) throw std::runtime_error(process_.stderr_text());
    address_ = text.substr(mark.size(), text.find('\n') - mark.size());
}

std::int64_t Served::peak_memory_bytes() const {
    std::ifstream status("/proc/" + std::to_string(process_.pid()) + "/status");
    for (std::string line; std::getline(status, line);)
        if (line.starts_with("VmHWM:")) return std::stoll(line.substr(6)) * 1024;
    return -1;
}

double Served::cpu_seconds() const {
    std::ifstream file("/proc/" + std::to_string(process_.pid()) + "/stat");
    std::string line;
    std::getline(file, line);
    std::istringstream fields(line.substr(line.rfind(')') + 2));
    std::string skipped;
    for (int i = 0; i < 11; ++i) fields >> skipped;  // state to cmajflt: proc(5)
    double user = 0.0;
    double system = 0.0;
    fields >> user >> system;
    return (user + system) / static_cast<double>(sysconf(_SC_CLK_TCK));
}

}  // namespace divemesh
