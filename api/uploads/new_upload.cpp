#include "api/uploads/new_upload.hpp"

#include "api/disk_guard.hpp"
#include "api/quota.hpp"
#include "api/uploads/upload_metadata.hpp"
#include "schemas/error.hpp"
#include "storage/upload_store.hpp"

namespace divemesh::api {

Upload enter_upload(const Services& services,
                    storage::Catalog& catalog,
                    const Upload& upload,
                    const std::vector<std::string>& part_ids) {
    const ServiceLimits& limits = services.limits;
    const std::int64_t wanted = upload.length_bytes.value_or(0);
    const std::int64_t needed = limits.min_free_bytes + wanted;
    if (reachable_bytes(services, needed) < needed)
        throw Error(ErrorCode::OutOfSpace,
                    "the server's disk has no space for " + std::to_string(wanted) +
                        " bytes: delete dives or results, or ask the administrator");
    if (!plan_of(upload.metadata).truth) require_dive_of_quota(services, upload.project);
    const storage::UploadLimits upload_limits{.max_bytes_of_project = limits.max_project_bytes,
                                              .max_open_of_project = limits.max_open_uploads,
                                              .max_open_of_token = limits.max_token_uploads};
    storage::UploadStore uploads(catalog);
    return upload.is_final() ? uploads.create_final(upload, part_ids, upload_limits)
                             : uploads.create(upload, upload_limits);
}

}  // namespace divemesh::api
