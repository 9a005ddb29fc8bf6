#pragma once

#include <filesystem>
#include <functional>
#include <vector>

#include "api/client/backoff.hpp"
#include "api/client/rest_client.hpp"
#include "schemas/artifact.hpp"

namespace divemesh::api::client {

struct DownloadObserver {
    std::function<void(std::int64_t bytes_done, std::int64_t bytes_total)> on_progress;
    Backoff::OnWait on_wait;
};

// Downloads artifacts of a job into `folder` under their names. Keeps a file that is there already
// with the right hash, and resumes an interrupted one by Range. A file gets its name only when its
// sha256 is the stated one. Throws Error{BadData} if the hash stays wrong.
void download_artifacts(const Account& account,
                        const std::vector<Artifact>& artifacts,
                        const std::filesystem::path& folder,
                        const DownloadObserver& observer);

}  // namespace divemesh::api::client
