#pragma once

#include <filesystem>
#include <string>

#include "api/http.hpp"
#include "api/services.hpp"

namespace divemesh::api {

struct ImportRequest {
    std::filesystem::path folder;
    std::string project = "default";
    std::string preset;  // of the reconstructions to queue; "": no reconstruction
};

// Imports the dives of a folder on this machine, e.g. of a disk that was carried home: each archive
// (zip, tar, tar.gz, tgz, tar.zst) and each dive folder in it, or the folder itself if it is a
// dive. The folder is only read; links, hard links and special files are refused. A dive that the
// project has is skipped; an interrupted import resumes. The result of each is logged: events
// import_taken, import_known, import_refused, import_ended.
Awaitable<void> import_dives(Services services, ImportRequest request);

}  // namespace divemesh::api
