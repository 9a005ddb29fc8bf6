#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "api/client/rest_client.hpp"
#include "tests/end_to_end/process.hpp"
#include "tests/temporary_folder.hpp"

namespace divemesh {

std::filesystem::path divemesh_program();

// What `divemesh simulate` renders by these options, once for all tests of one build of the
// program.
std::filesystem::path simulated_dive(const std::vector<std::string>& options);
std::filesystem::path small_dive();  // of the tank

struct Outcome {
    int exit_code = -1;
    std::string out;
    std::string err;
};

// A server on loopback with its data in a folder of its own, and whatever else is started around
// it. Everything is killed with it.
class Service {
public:
    Service();

    // On the port of the first start, so that a client finds it again.
    void start_server(int num_workers);
    void kill_server();
    Process start_worker() const;

    // `divemesh ...` as a user of this server.
    Process start(std::vector<std::string> arguments) const;
    Outcome run(const std::vector<std::string>& arguments,
                std::chrono::seconds timeout = std::chrono::seconds(60)) const;

    api::client::RestClient rest() const;
    nlohmann::json jobs() const;
    nlohmann::json dives() const;
    nlohmann::json job(const std::string& id) const;
    // The only reconstruction that the server has; waits until it is in that state.
    nlohmann::json wait_for_reconstruction(const std::string& state,
                                           std::chrono::seconds timeout) const;

    std::filesystem::path operator/(const std::string& name) const { return folder_ / name; }
    Process& server() { return *server_; }
    const std::string& address() const { return address_; }
    const std::string& token() const { return token_; }
    std::vector<std::string> processes() const;  // command lines of all that name our folder

private:
    std::string data() const { return (folder_ / "data").string(); }
    Process::Environment environment() const;

    TemporaryFolder folder_;
    std::string token_;
    std::string address_;
    std::optional<Process> server_;
};

}  // namespace divemesh
