#include "api/new_upload.hpp"

#include "api/quota.hpp"
#include "schemas/error.hpp"
#include "storage/upload_store.hpp"

namespace divemesh::api {

Upload enter_upload(const Services& services, const Upload& upload, std::int64_t repeated_bytes) {
    storage::UploadStore uploads(services.catalog);
    const std::int64_t room = services.blobs.free_bytes() - services.limits.min_free_bytes;
    const std::int64_t wanted = upload.length_bytes.value_or(0);
    if (wanted > room)
        throw Error(ErrorCode::OutOfSpace,
                    "the server's disk has no room for " + std::to_string(wanted) + " bytes");
    if (uploads.num_open(upload.project) >= services.limits.max_open_uploads)
        throw Error(ErrorCode::TooMany,
                    "project " + upload.project + " has " +
                        std::to_string(services.limits.max_open_uploads) +
                        " unfinished uploads: finish or delete some");
    require_dive_of_quota(services, upload.project);
    return uploads.create(upload, services.limits.max_project_bytes, repeated_bytes);
}

}  // namespace divemesh::api
