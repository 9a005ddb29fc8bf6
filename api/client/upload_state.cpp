#include "api/client/upload_state.hpp"

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <fcntl.h>
#include <fstream>
#include <nlohmann/json.hpp>
#include <unistd.h>

#include "schemas/content_hash.hpp"
#include "schemas/error.hpp"
#include "schemas/file_descriptor.hpp"

namespace divemesh::api::client {
namespace {

[[noreturn]] void throw_errno(const std::string& path) {
    throw Error(ErrorCode::OutOfSpace,
                "cannot write " + path + ": " + std::strerror(errno) + ": free some space");
}

// Makes a file durable. Given a folder, it makes the name of a new file in it durable.
void sync(const std::string& path) {
    const FileDescriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
    if (!file.is_open() || ::fsync(file.get()) != 0) throw_errno(path);
}

void write_durably(const std::filesystem::path& path, const std::string& text) {
    std::filesystem::create_directories(path.parent_path());
    const auto temporary = path.string() + "." + std::to_string(::getpid());
    std::ofstream stream(temporary, std::ios::trunc);
    stream << text << '\n';
    stream.close();
    if (!stream) throw_errno(temporary);
    sync(temporary);
    std::filesystem::rename(temporary, path);
    sync(path.parent_path().string());
}

}  // namespace

UploadState::UploadState(const std::filesystem::path& folder,
                         const std::string& server,
                         const std::string& archive_sha256)
    : file_(folder / ("upload-" + sha256_hex(server + "\n" + archive_sha256) + ".json")) {}

RememberedUpload UploadState::load() const {
    std::ifstream stream(file_);
    if (!stream) return {};
    try {
        const auto json = nlohmann::json::parse(stream);
        return {json.value("upload", ""),
                json.value("parts", std::vector<std::string>()),
                json.value("joining", false)};
    } catch (const nlohmann::json::exception&) {
        return {};
    }
}

void UploadState::save(const RememberedUpload& remembered) const {
    const nlohmann::json json = {{"upload", remembered.upload},
                                 {"parts", remembered.parts},
                                 {"joining", remembered.joining}};
    write_durably(file_, json.dump());
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
