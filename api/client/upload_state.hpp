#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace divemesh::api::client {

// How far an upload has come, as addresses on its server.
struct RememberedUpload {
    std::string upload;              // "/api/v1/uploads/<id>" of the whole; "": not yet created
    std::vector<std::string> parts;  // of a parallel upload, "" for one not begun; else empty
    bool joining = false;            // every part is complete: the final upload has been requested

    bool operator==(const RememberedUpload&) const = default;
};

// Remembers on this machine which upload sends a dive, so that a client resumes it after a kill or
// a power cut. One small file per server, by its id or address, and archive in `folder`, durable
// before save() returns.
class UploadState {
public:
    UploadState(const std::filesystem::path& folder,
                const std::string& server,
                const std::string& archive_sha256);

    RememberedUpload load() const;  // empty if the file is missing or unreadable
    void save(const RememberedUpload& remembered) const;
    void forget() const;

private:
    std::filesystem::path file_;
};

// Returns $XDG_STATE_HOME/divemesh, or ~/.local/state/divemesh.
std::filesystem::path default_state_folder();

}  // namespace divemesh::api::client
