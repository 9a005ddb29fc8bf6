#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <string>

#include "api/client/rest_client.hpp"
#include "cli/command.hpp"

namespace divemesh::cli {

// A file of truth that a job is to read.
struct TruthToSend {
    std::filesystem::path file;
    std::string kind;
    std::string subject;  // whose it is: id of a dive, or of a reconstruction of it
};

// A job that is asked of a server beside reconstructions: an accuracy report or a comparison.
struct ServerJob {
    std::string subject;  // id of a dive, or of a reconstruction
    std::string kind;
    nlohmann::json options = nlohmann::json::object();
    std::map<std::string, TruthToSend> truth;  // sent first, by the option that names it
    bool wait = true;                          // until it is finished
    std::filesystem::path out;                 // then fetch the artifacts to here; "": no
};

// Whether a command with the option --server means something there, not a folder here.
bool is_on_server(const CLI::App& command, const std::filesystem::path& subject);

// Sends the truth, makes the job and waits as it is told, then calls `done` with the address of its
// artifacts ("/api/v1/jobs/.../artifacts/"). Returns the exit code: of `done`; kExitFailed when the
// job came to nothing, which stderr then explains; kExitDone with the job's id on stdout when it is
// not waited for.
int run_on_server(api::client::RestClient& rest,
                  const ServerJob& wanted,
                  const Context& context,
                  const std::function<int(const std::string& artifacts)>& done);

}  // namespace divemesh::cli
