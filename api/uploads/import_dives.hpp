#pragma once

#include <filesystem>
#include <string>

#include "api/http.hpp"
#include "api/services.hpp"

namespace divemesh::api {

struct ImportRequest {
    std::filesystem::path folder;
    std::string project = "default";
    std::string preset;  // of the reconstructions to queue; "": none
};

// Takes the dives of a folder on this machine, a disk that was carried home say: each archive
// (zip, tar, tar.gz, tgz, tar.zst) and each dive's folder in it, or the folder itself when it is
// one. The folder is only read; links, hard links and special files are refused. A dive that the
// project has is left alone, an import that was cut goes on where it stopped. What became of each
// is logged: events import_taken, import_known, import_refused, import_ended.
Awaitable<void> import_dives(Services services, ImportRequest request);

}  // namespace divemesh::api
