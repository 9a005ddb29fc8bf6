#pragma once

#include <filesystem>
#include <string>

#include "api/client/rest_client.hpp"
#include "cli/preset_options.hpp"
#include "schemas/dive.hpp"

namespace divemesh::cli {

// Options of sending a dive to a server.
struct SendOptions {
    std::filesystem::path dive;
    PresetOptions preset;
    bool no_job = false;  // the dive is stored, not reconstructed
    double limit_rate_bytes_per_s = 0.0;
    double stall_timeout_s = 30.0;
    int parallel = 1;
};

struct SentDive {
    Dive dive;
    bool verified = false;
    std::string job_id;  // "": no reconstruction
};

// Sends a dive that the server does not have yet, resumes one that was begun, and asks for its
// reconstruction. Shows a progress bar. A dive that is not `verified` must be kept until it is
// ready.
SentDive send_dive(api::client::RestClient& rest, const SendOptions& options);

}  // namespace divemesh::cli
