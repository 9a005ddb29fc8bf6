#include "api/client/upload_state.hpp"

#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>
#include <unistd.h>

#include "schemas/content_hash.hpp"
#include "schemas/error.hpp"

namespace divemesh::api::client {

UploadState::UploadState(const std::filesystem::path& folder,
                         const std::string& server_url,
                         const std::string& archive_sha256)
    : file_(folder / ("upload-" + sha256_hex(server_url + "\n" + archive_sha256) + ".json")) {}

std::optional<std::string> UploadState::upload_path() const {
    std::ifstream stream(file_);
    if (!stream) return std::nullopt;
    const auto json = nlohmann::json::parse(stream, nullptr, false);
    if (!json.is_object() || !json.contains("upload") || !json["upload"].is_string())
        return std::nullopt;
    return json["upload"].get<std::string>();
}

void UploadState::remember(const std::string& upload_path) const {
    std::filesystem::create_directories(file_.parent_path());
    const auto temporary = file_.string() + "." + std::to_string(::getpid());
    std::ofstream stream(temporary, std::ios::trunc);
    stream << nlohmann::json{{"upload", upload_path}}.dump() << '\n';
    stream.close();
    if (!stream)
        throw Error(ErrorCode::OutOfSpace, "cannot write " + temporary + "; free some space");
    std::filesystem::rename(temporary, file_);
}

void UploadState::forget() const {
    std::error_code ignored;
    std::filesystem::remove(file_, ignored);
}

std::filesystem::path default_state_folder() {
    if (const char* state = std::getenv("XDG_STATE_HOME"); state != nullptr && *state != '\0')
        return std::filesystem::path(state) / "divemesh";
    const char* home = std::getenv("HOME");
    return std::filesystem::path(home != nullptr ? home : ".") / ".local" / "state" / "divemesh";
}

}  // namespace divemesh::api::client
