#include "api/client/download.hpp"

#include <fstream>

#include "api/client/byte_source.hpp"
#include "api/client/dive_tar.hpp"
#include "schemas/error.hpp"

namespace divemesh::api::client {
namespace {

namespace fs = std::filesystem;

constexpr std::chrono::seconds kStall{30};

// Returns the path for an artifact's name. A server is not trusted with names on the local disk.
fs::path target_of(const fs::path& folder, const std::string& name) {
    const fs::path path(name);
    bool ok = !name.empty() && path.is_relative() && name.find('\0') == std::string::npos;
    for (const auto& part : path) ok = ok && part != ".." && part != "." && !part.empty();
    if (!ok)
        throw Error(ErrorCode::BadData,
                    "the server sent the invalid artifact name \"" + name + "\": it is refused");
    return folder / path;
}

std::int64_t size_of(const fs::path& file) {
    std::error_code missing;
    const auto size = fs::file_size(file, missing);
    return missing ? 0 : static_cast<std::int64_t>(size);
}

bool has_hash(const fs::path& file, const Artifact& artifact) {
    if (!fs::is_regular_file(fs::symlink_status(file)) || size_of(file) != artifact.size_bytes)
        return false;
    FileSource source(file);
    return hash_archive(source, [](std::int64_t) {}).archive_sha256 == artifact.sha256;
}

std::string artifact_path(const Artifact& artifact) {
    std::string path = job_path(artifact.job_id) + "/artifacts";
    for (const auto& part : fs::path(artifact.name)) {
        path += '/';
        path += percent_encode(part.string());
    }
    return path;
}

class Download {
public:
    Download(const Account& account, const DownloadObserver& observer)
        : account_(account), observer_(observer), connection_(account.server, kStall) {}

    void fetch(const Artifact& artifact, const fs::path& target, const BytesDone& bytes_done) {
        const fs::path part = target.string() + ".part";
        fs::create_directories(target.parent_path());
        Backoff backoff(account_.give_up_after, observer_.on_wait);
        int num_wrong_hashes = 0;
        while (true) {
            try {
                if (size_of(part) < artifact.size_bytes || artifact.size_bytes == 0)
                    fetch_rest(artifact, part, backoff, bytes_done);
                if (has_hash(part, artifact)) return fs::rename(part, target);
                fs::remove(part);
                if (++num_wrong_hashes == 2)
                    throw Error(ErrorCode::BadData,
                                artifact.name +
                                    " arrived with another sha256 than the server states: download "
                                    "it again");
            } catch (const Error& error) {
                if (error.code() != ErrorCode::Unavailable) throw;
                backoff.wait(error);
            }
        }
    }

private:
    void fetch_rest(const Artifact& artifact,
                    const fs::path& part,
                    Backoff& backoff,
                    const BytesDone& bytes_done) {
        std::int64_t have = size_of(part);
        HttpRequest request{"GET", artifact_path(artifact), authorization(account_), ""};
        if (have > 0) {
            request.headers.emplace_back("Range", "bytes=" + std::to_string(have) + "-");
            request.headers.emplace_back("If-Range", "\"" + artifact.sha256 + "\"");
        }
        std::ofstream stream;
        BodySink sink;
        sink.on_header = [&](const HttpResponse& header) {
            if (header.status != 200 && header.status != 206) return false;
            const bool goes_on = header.status == 206;
            if (!goes_on) have = 0;
            stream.open(part, std::ios::binary | (goes_on ? std::ios::app : std::ios::trunc));
            return true;
        };
        sink.on_bytes = [&](std::span<const char> bytes) {
            stream.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
            if (!stream) throw Error(ErrorCode::OutOfSpace, "cannot write " + part.string());
            have += static_cast<std::int64_t>(bytes.size());
            if (have > artifact.size_bytes)
                throw Error(ErrorCode::BadData,
                            artifact.name + " is longer than the server states: download it again");
            backoff.moved();
            bytes_done(have);
        };
        const HttpResponse response = connection_.receive(request, sink);
        if (response.status != 200 && response.status != 206) throw error_of(response);
        stream.close();
        if (!stream) throw Error(ErrorCode::OutOfSpace, "cannot write " + part.string());
    }

    const Account& account_;
    const DownloadObserver& observer_;
    HttpConnection connection_;
};

}  // namespace

void download_artifacts(const Account& account,
                        const std::vector<Artifact>& artifacts,
                        const fs::path& folder,
                        const DownloadObserver& observer) {
    std::int64_t total = 0;
    for (const auto& artifact : artifacts) total += artifact.size_bytes;
    Download download(account, observer);
    std::int64_t before = 0;
    for (const auto& artifact : artifacts) {
        const fs::path target = target_of(folder, artifact.name);
        if (!has_hash(target, artifact))
            download.fetch(artifact, target, [&](std::int64_t done) {
                if (observer.on_progress) observer.on_progress(before + done, total);
            });
        before += artifact.size_bytes;
        if (observer.on_progress) observer.on_progress(before, total);
    }
}

}  // namespace divemesh::api::client
