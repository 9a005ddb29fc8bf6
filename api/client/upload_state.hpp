#pragma once

#include <filesystem>
#include <optional>
#include <string>

namespace divemesh::api::client {

// Remembers on this machine which upload a dive is being sent by, so that a client that was killed
// goes on where it stopped. One small file per server and archive in `folder`, written atomically.
class UploadState {
public:
    UploadState(const std::filesystem::path& folder,
                const std::string& server_url,
                const std::string& archive_sha256);

    std::optional<std::string> upload_path() const;  // "/api/v1/uploads/<id>"; nothing: unknown
    void remember(const std::string& upload_path) const;
    void forget() const;

private:
    std::filesystem::path file_;
};

// $XDG_STATE_HOME/divemesh, else ~/.local/state/divemesh.
std::filesystem::path default_state_folder();

}  // namespace divemesh::api::client
