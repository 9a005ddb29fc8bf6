#pragma once

#include <CLI/App.hpp>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "api/client/rest_client.hpp"

namespace divemesh::cli {

// --server and the token, shared by every sub-command that uses a server.
struct ServerOptions {
    std::string server = "http://127.0.0.1:8080";
    std::filesystem::path token_file;
    std::string ca_file;
    double give_up_after_s = 600.0;  // without an answer; 0: never
};

// Adds --server, --token-file and --ca-file.
void add_server_options(CLI::App& command, ServerOptions& options);

// Adds --give-up-after, to a command that waits for a server which is away.
void add_give_up_after(CLI::App& command, ServerOptions& options);

// Adds --newest to a command that lists what is on a server.
void add_newest(CLI::App& command, int& newest);
// Returns the items of a list: the newest so many, newest first; if that is 0 all, oldest first.
std::vector<nlohmann::json> listed(api::client::RestClient& rest,
                                   const std::string& path,
                                   api::client::QueryParameters query,
                                   int newest);

// Returns the account. The token comes from --token-file, otherwise from DIVEMESH_TOKEN. Throws
// Error{NotFound} if the file cannot be read.
api::client::Account account_of(const ServerOptions& options);

}  // namespace divemesh::cli
