#include "tests/bench/served.hpp"

#include <chrono>
#include <cstdlib>
#include <ctime>
#include <nlohmann/json.hpp>
#include <sstream>
#include <stdexcept>

namespace divemesh {

using namespace std::chrono_literals;

namespace {

std::vector<std::string> command_of(const std::filesystem::path& program,
                                    const std::filesystem::path& data,
                                    const std::vector<std::string>& options) {
    std::vector<std::string> command = {program.string(),
                                        "serve",
                                        "--data",
                                        data.string(),
                                        "--listen",
                                        "127.0.0.1:0",
                                        "--workers",
                                        "0"};
    command.insert(command.end(), options.begin(), options.end());
    return command;
}

}  // namespace

Served::Served(const std::filesystem::path& program,
               const std::filesystem::path& data,
               const std::vector<std::string>& options,
               const Process::Environment& environment)
    : process_(command_of(program, data, options), data.parent_path(), environment) {
    const std::string mark = "listening on ";
    const bool up =
        wait_until(60s, [&] { return process_.stdout_text().find('\n') != std::string::npos; });
    const std::string text = process_.stdout_text();
    if (!up || !text.starts_with(mark)) throw std::runtime_error(process_.stderr_text());
    address_ = text.substr(mark.size(), text.find('\n') - mark.size());
}

// Of lines of the log that tell of a request.
std::vector<std::int64_t> Served::times_of(const std::string& path) const {
    std::vector<std::int64_t> times;
    std::istringstream lines(process_.stderr_text());
    for (std::string line; std::getline(lines, line);) {
        const auto entry = nlohmann::json::parse(line, nullptr, false);
        if (entry.is_discarded() || entry["data"].value("path", "") != path) continue;
        std::tm date{};
        const std::string time = entry["time"];
        const char* rest = strptime(time.c_str(), "%Y-%m-%dT%H:%M:%S", &date);
        times.push_back(1000 * std::int64_t{timegm(&date)} + std::atoi(rest + 1));
    }
    return times;
}

}  // namespace divemesh
