#pragma once

#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "api/client/rest_client.hpp"

namespace divemesh::cli {

// A job that is asked of a server beside reconstructions: an accuracy report or a comparison.
struct ServerJob {
    std::string subject;  // id of a dive, or of a reconstruction
    std::string kind;
    nlohmann::json options = nlohmann::json::object();
    std::map<std::string, std::filesystem::path> truth;  // files to be sent first, by their kind
    bool wait = true;                                    // until it is finished
    std::filesystem::path out;                           // then fetch the artifacts to here; "": no
};

struct ServerJobEnd {
    std::string job_id;
    bool finished = false;  // false: it was not waited for
    bool succeeded = false;
};

// Sends the truth, makes the job and waits as it is told; what went wrong with it is on stderr.
ServerJobEnd run_on_server(api::client::RestClient& rest, const ServerJob& wanted);

}  // namespace divemesh::cli
