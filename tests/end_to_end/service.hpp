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

// Returns the folder of a dive that `divemesh simulate` rendered with these options. A dive is
// rendered once for each build of the program.
std::filesystem::path simulated_dive(const std::vector<std::string>& options);
std::filesystem::path small_dive();  // in the scene `tank`

struct Outcome {
    int exit_code = -1;
    std::string out;
    std::string err;
};

// A server on loopback with its data in a temporary folder, and the programs that a test runs with
// it. The destructor kills the server.
class Service {
public:
    // `catalog_url` "": a catalog in the data folder.
    explicit Service(std::string catalog_url = "");
    // Its blobs are in an object store, to which the environment has the keys.
    Service(std::string blobs, Process::Environment keys);

    // Starts the server, on the port of its first start, so that a client finds it again.
    void start_server(int num_workers);
    void kill_server();
    // Without the server's data folder where the blobs are in an object store.
    Process start_worker() const;

    // Starts `divemesh` with these arguments as a user of this server.
    Process start(std::vector<std::string> arguments) const;
    Outcome run(const std::vector<std::string>& arguments,
                std::chrono::seconds timeout = std::chrono::seconds(60)) const;

    api::client::RestClient rest() const;
    nlohmann::json jobs() const;
    nlohmann::json dives() const;
    nlohmann::json job(const std::string& id) const;
    // Waits until the server's only reconstruction is in that state and returns it.
    nlohmann::json wait_for_reconstruction(const std::string& state,
                                           std::chrono::seconds timeout) const;

    std::filesystem::path operator/(const std::string& name) const { return folder_ / name; }
    Process& server() { return *server_; }
    const std::string& address() const { return address_; }
    const std::string& token() const { return token_; }
    std::vector<std::string> processes() const;  // command lines that name our folder

private:
    Service(std::string catalog_url, std::string blobs, Process::Environment keys);

    std::string data() const { return (folder_ / "data").string(); }
    Process::Environment environment() const;

    TemporaryFolder folder_;
    std::string catalog_url_;
    std::string blobs_;  // "": in the data folder
    Process::Environment keys_;
    std::string token_;
    std::string address_;
    std::optional<Process> server_;
};

}  // namespace divemesh
