#pragma once

#include <CLI/App.hpp>
#include <filesystem>
#include <string>

#include "api/client/rest_client.hpp"

namespace divemesh::cli {

// --server and the token, shared by every sub-command that uses a server.
struct ServerOptions {
    std::string server = "http://127.0.0.1:8080";
    std::filesystem::path token_file;
    std::string ca_file;
};

// Adds --server, --token-file and --ca-file.
void add_server_options(CLI::App& command, ServerOptions& options);

// Returns the account. The token comes from --token-file, otherwise from DIVEMESH_TOKEN. Throws
// Error{NotFound} if the file cannot be read.
api::client::Account account_of(const ServerOptions& options);

}  // namespace divemesh::cli
