#include "tests/end_to_end/service.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <stdexcept>
#include <unistd.h>

#include "schemas/content_hash.hpp"

namespace divemesh {
namespace {

namespace fs = std::filesystem;

// "http://127.0.0.1:41235" of the line that the server prints when it is ready.
std::string address_in(const std::string& text) {
    const std::string mark = "listening on ";
    const std::size_t at = text.find(mark);
    if (at == std::string::npos) return "";
    const std::size_t start = at + mark.size();
    const std::size_t end = text.find_first_of(" \n", start);
    return end == std::string::npos ? "" : text.substr(start, end - start);
}

std::string first_line(const std::string& text) { return text.substr(0, text.find('\n')); }

nlohmann::json parse(const Outcome& outcome) {
    if (outcome.exit_code != 0) throw std::runtime_error(outcome.err);
    return nlohmann::json::parse(outcome.out);
}

}  // namespace

fs::path divemesh_program() { return DIVEMESH_PROGRAM; }

fs::path simulated_dive(const std::vector<std::string>& options) {
    const auto built = fs::last_write_time(divemesh_program()).time_since_epoch().count();
    std::vector<std::string> command = {divemesh_program().string(), "simulate"};
    command.insert(command.end(), options.begin(), options.end());
    std::string what = std::to_string(built);
    for (const std::string& word : command) what += '\n' + word;
    const fs::path folder = fs::temp_directory_path() /
                            ("divemesh-test-" + std::to_string(::getuid())) / sha256_hex(what);
    if (fs::exists(folder)) return folder;
    const TemporaryFolder scratch;
    const fs::path made = folder.string() + "." + std::to_string(::getpid());
    fs::create_directories(folder.parent_path());
    command.insert(command.end(), {"--out", made.string()});
    Process simulate(command, scratch.path());
    if (simulate.wait(std::chrono::seconds(300)) != 0)
        throw std::runtime_error("divemesh simulate: " + simulate.stderr_text());
    std::error_code lost;  // another test may have been first
    fs::rename(made, folder, lost);
    if (lost) fs::remove_all(made);
    return folder;
}

fs::path small_dive() {
    // clang-format off
    return simulated_dive({"--scene", "tank", "--length-m", "1", "--rate", "10",
                           "--width-px", "320", "--height-px", "240"});
    // clang-format on
}

Service::Service(std::string catalog_url) : Service(std::move(catalog_url), "", {}) {}

Service::Service(std::string blobs, Process::Environment keys)
    : Service("", std::move(blobs), std::move(keys)) {}

Service::Service(std::string catalog_url, std::string blobs, Process::Environment keys)
    : catalog_url_(std::move(catalog_url)), blobs_(std::move(blobs)), keys_(std::move(keys)) {
    const Outcome made =
        run({"token", "create", "--data", data(), "--name", "test", "--scope", "admin"});
    if (made.exit_code != 0) throw std::runtime_error(made.err);
    token_ = first_line(made.out);
}

void Service::start_server(int num_workers) {
    const std::string listen =
        address_.empty() ? "127.0.0.1:0" : address_.substr(std::string("http://").size());
    server_.reset();
    // clang-format off
    std::vector<std::string> command = {divemesh_program().string(), "serve",
                                        "--data", data(), "--listen", listen,
                                        "--workers", std::to_string(num_workers),
                                        "--allow-origin", "http://lab.example"};
    // clang-format on
    if (!blobs_.empty()) command.insert(command.end(), {"--blobs", blobs_});
    server_.emplace(command, folder_.path(), environment());
    std::string address;
    wait_until(std::chrono::seconds(60), [&] {
        address = address_in(server_->stdout_text());
        return !address.empty() || server_->wait(std::chrono::seconds(0));
    });
    if (address.empty())
        throw std::runtime_error("the server did not start: " + server_->stderr_text());
    address_ = address;
}

void Service::kill_server() { server_->kill(); }

Process Service::start_worker() const {
    if (blobs_.empty()) return start({"worker", "--data", data()});
    // clang-format off
    return start({"worker", "--catalog", "sqlite://" + data() + "/catalog.db", "--blobs", blobs_,
                  "--data", (folder_ / "scratch").string()});
    // clang-format on
}

Process Service::start(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), divemesh_program().string());
    return Process(arguments, folder_.path(), environment());
}

Outcome Service::run(const std::vector<std::string>& arguments,
                     std::chrono::seconds timeout) const {
    Process process = start(arguments);
    const auto exit_code = process.wait(timeout);
    return {exit_code.value_or(-1), process.stdout_text(), process.stderr_text()};
}

api::client::RestClient Service::rest() const {
    return api::client::RestClient({api::client::parse_server_url(address_), token_});
}

nlohmann::json Service::jobs() const { return parse(run({"jobs", "--json"})); }
nlohmann::json Service::dives() const { return parse(run({"dives", "--json"})); }
nlohmann::json Service::job(const std::string& id) const { return parse(run({"jobs", id})); }

nlohmann::json Service::wait_for_reconstruction(const std::string& state,
                                                std::chrono::seconds timeout) const {
    nlohmann::json found;
    const bool reached = wait_until(timeout, [&] {
        for (const auto& item : jobs())
            if (item.at("kind") == "reconstruct") found = item;
        return !found.is_null() && found.at("state") == state;
    });
    EXPECT_TRUE(reached) << "the reconstruction is not " << state << ": " << found.dump(2);
    return found;
}

std::vector<std::string> Service::processes() const {
    std::vector<std::string> found;
    for (const auto& entry : fs::directory_iterator("/proc")) {
        const std::string pid = entry.path().filename().string();
        if (pid.find_first_not_of("0123456789") != std::string::npos) continue;
        std::string command = read_text(entry.path() / "cmdline");
        std::replace(command.begin(), command.end(), '\0', ' ');
        if (command.find(folder_.path().string()) != std::string::npos)
            found.push_back(pid + " " + command);
    }
    return found;
}

Process::Environment Service::environment() const {
    Process::Environment environment = keys_;
    environment.insert({{"DIVEMESH_TOKEN", token_},
                        {"DIVEMESH_SERVER", address_},
                        {"XDG_STATE_HOME", (folder_ / "state").string()},
                        {"XDG_CONFIG_HOME", (folder_ / "config").string()}});
    if (!catalog_url_.empty()) environment["DIVEMESH_CATALOG"] = catalog_url_;
    return environment;
}

}  // namespace divemesh
