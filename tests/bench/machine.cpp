#include "tests/bench/machine.hpp"

#include <ctime>
#include <fstream>
#include <string>
#include <sys/sysinfo.h>
#include <sys/utsname.h>
#include <thread>

namespace divemesh::bench {
namespace {

std::string cpu_model() {
    std::ifstream info("/proc/cpuinfo");
    for (std::string line; std::getline(info, line);)
        if (line.starts_with("model name")) return line.substr(line.find(':') + 2);
    return "unknown";
}

std::string utc_now() {
    const std::time_t now = std::time(nullptr);
    std::tm parts{};
    gmtime_r(&now, &parts);
    char text[32];
    std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%SZ", &parts);
    return text;
}

}  // namespace

nlohmann::json describe_machine() {
    utsname system{};
    uname(&system);
    struct sysinfo memory {};
    sysinfo(&memory);
    return {{"cpu", cpu_model()},
            {"cores", std::thread::hardware_concurrency()},
            {"memory_bytes", static_cast<std::int64_t>(memory.totalram) * memory.mem_unit},
            {"load_1min", static_cast<double>(memory.loads[0]) / (1 << SI_LOAD_SHIFT)},
            {"system", std::string(system.sysname) + " " + system.release},
            {"date", utc_now()}};
}

}  // namespace divemesh::bench
