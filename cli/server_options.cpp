#include "cli/server_options.hpp"

#include <cstdlib>
#include <fstream>

namespace divemesh::cli {
namespace {

std::string token_of(const ServerOptions& options) {
    if (!options.token_file.empty()) {
        std::ifstream stream(options.token_file);
        std::string token;
        if (!(stream >> token))
            throw Error(
                ErrorCode::NotFound,
                "cannot read a token from " + options.token_file.string() + ": check --token-file");
        return token;
    }
    const char* token = std::getenv("DIVEMESH_TOKEN");
    return token != nullptr ? token : "";
}

}  // namespace

void add_server_options(CLI::App& command, ServerOptions& options) {
    command.add_option("--server", options.server, "address of the server")->capture_default_str();
    command.add_option(
        "--token-file", options.token_file, "file with the token (default: DIVEMESH_TOKEN)");
    command
        .add_option("--ca-file",
                    options.ca_file,
                    "PEM certificates to trust for https, in addition to the system's")
        ->envname("DIVEMESH_CA_FILE");
}

api::client::Account account_of(const ServerOptions& options) {
    api::client::ServerAddress server = api::client::parse_server_url(options.server);
    server.ca_file = options.ca_file;
    return {std::move(server), token_of(options)};
}

}  // namespace divemesh::cli
