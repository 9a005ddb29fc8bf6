#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <string>

#include "api/client/rest_client.hpp"
#include "cli/command.hpp"

namespace divemesh::cli {

// A file of truth that a job reads.
struct TruthToSend {
    std::filesystem::path file;
    std::string kind;
    std::string subject;  // id of its dive, or of a reconstruction of that dive
};

// A job on a server other than a reconstruction: an accuracy report or a comparison.
struct ServerJob {
    std::string subject;  // id of a dive, or of a reconstruction
    std::string kind;
    nlohmann::json options = nlohmann::json::object();
    std::map<std::string, TruthToSend> truth;  // sent first, by the option that names it
    bool wait = true;                          // until it has finished
    std::filesystem::path out;                 // where to download the artifacts; "": nowhere
};

// Returns whether a command with the option --server is meant for the server, not for a local
// folder.
bool is_on_server(const CLI::App& command, const std::filesystem::path& subject);

// Sends the truth, creates the job and waits if wanted, then calls `done` with the URL of its
// artifacts ("/api/v1/jobs/.../artifacts/"). Returns the exit code: that of `done`; kExitFailed if
// the job did not succeed, which stderr explains; kExitDone, with the job's id on stdout, if it
// does not wait.
int run_on_server(api::client::RestClient& rest,
                  const ServerJob& wanted,
                  const Context& context,
                  const std::function<int(const std::string& artifacts)>& done);

}  // namespace divemesh::cli
