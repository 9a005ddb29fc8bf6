#include "worker/dive/archive_identity.hpp"

#include "worker/dive/dive_files.hpp"
#include "worker/dive/dive_source.hpp"

namespace divemesh::dive {

std::string archive_content_sha256(const std::filesystem::path& archive,
                                   const base::ProgressCallback& progress) {
    constexpr auto kNowhere = "";  // hashes are made while unpacking, so no file has to be kept
    const DiveFiles files(open_archive(archive, kNowhere, DiveLimits{}, progress));
    return files.content_hash(base::ignore_progress).sha256;
}

}  // namespace divemesh::dive
