#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace divemesh::api::client {

// How far an upload has come, in addresses on its server.
struct RememberedUpload {
    std::string upload;              // "/api/v1/uploads/<id>" of the whole; "": none yet
    std::vector<std::string> parts;  // of a parallel upload, "" where it is not begun; else empty
    bool joining = false;            // every part is there: the whole has been asked for

    bool operator==(const RememberedUpload&) const = default;
};

// Remembers on this machine by which upload a dive is being sent, so that a client that was killed,
// or whose machine was, goes on where it stopped. One small file per server and archive in
// `folder`, on disk before save() returns.
class UploadState {
public:
    UploadState(const std::filesystem::path& folder,
                const std::string& server_url,
                const std::string& archive_sha256);

    RememberedUpload load() const;  // empty when there is none, or it cannot be read
    void save(const RememberedUpload& remembered) const;
    void forget() const;

private:
    std::filesystem::path file_;
};

// $XDG_STATE_HOME/divemesh, else ~/.local/state/divemesh.
std::filesystem::path default_state_folder();

}  // namespace divemesh::api::client
