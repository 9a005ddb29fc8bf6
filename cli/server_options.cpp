#include "cli/server_options.hpp"

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <fstream>

namespace divemesh::cli {
namespace {

constexpr double kMaxGiveUpAfter_s = 1e9;

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

void add_give_up_after(CLI::App& command, ServerOptions& options) {
    command
        .add_option("--give-up-after",
                    options.give_up_after_s,
                    "fail after this many seconds without an answer of the server; 0: never")
        ->check(CLI::Range(0.0, kMaxGiveUpAfter_s))
        ->capture_default_str();
}

void add_newest(CLI::App& command, int& newest) {
    command.add_option("--newest", newest, "list only this many, the newest first")
        ->check(CLI::Range(1, 10'000));
}

std::vector<nlohmann::json> listed(api::client::RestClient& rest,
                                   const std::string& path,
                                   api::client::QueryParameters query,
                                   int newest) {
    if (newest == 0) return rest.list(path, std::move(query));
    constexpr int kMaxPage = 200;
    query.emplace_back("order", "newest");
    query.emplace_back("limit", std::to_string(std::min(newest, kMaxPage)));
    return rest.list(path, std::move(query), static_cast<std::size_t>(newest));
}

api::client::Account account_of(const ServerOptions& options) {
    api::client::ServerAddress server = api::client::parse_server_url(options.server);
    server.ca_file = options.ca_file;
    const std::chrono::milliseconds give_up_after(
        static_cast<std::int64_t>(options.give_up_after_s * 1000.0));
    return {std::move(server), token_of(options), give_up_after};
}

}  // namespace divemesh::cli
