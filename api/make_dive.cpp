#include "api/make_dive.hpp"

#include <spdlog/spdlog.h>
#include <vector>

#include "api/audit.hpp"
#include "schemas/error.hpp"
#include "storage/dive_store.hpp"
#include "storage/upload_store.hpp"

namespace divemesh::api {
namespace {

constexpr std::size_t kReadBytes = std::size_t{1} << 20;

std::string hash_of(storage::BlobReader& reader, const std::atomic<bool>& stopping) {
    Sha256 hash;
    std::vector<char> buffer(kReadBytes);
    for (std::int64_t offset = 0;;) {
        if (stopping) throw Error(ErrorCode::Unavailable, "the server stops: ask again");
        const std::size_t n = reader.read_at(offset, buffer);
        if (n == 0) return hash.hex();
        hash.update({buffer.data(), n});
        offset += static_cast<std::int64_t>(n);
    }
}

std::string archive_sha256(const Services& services, const Upload& upload) {
    if (const auto hash = services.hashes.take(upload.id, upload.offset_bytes)) return hash->hex();
    const std::string key = archive_key(upload);
    // A server killed before the catalog knew has left the bytes where the dive's blob is.
    const auto reader = services.blobs.exists(key) ? services.blobs.open(key)
                                                   : services.blobs.read_staged(upload.blob);
    return hash_of(*reader, services.stopping);
}

std::string name_of(const Upload& upload, const UploadPlan& plan) {
    return plan.name.empty() ? upload.id : plan.name;
}

}  // namespace

std::string archive_key(const Upload& upload) { return "dives/" + upload.id + "/archive"; }

MadeDive make_dive(const Services& services,
                   storage::Catalog& catalog,
                   const Upload& upload,
                   const UploadPlan& plan) {
    if (!upload.complete())
        throw Error(ErrorCode::Conflict,
                    "upload " + upload.id + " has " + std::to_string(upload.offset_bytes) + " of " +
                        (upload.length_bytes ? std::to_string(*upload.length_bytes) : "unknown") +
                        " bytes: send the rest first");
    if (upload.is_partial())
        throw Error(ErrorCode::Conflict,
                    "upload " + upload.id + " is a part: make the final upload of it first");
    if (upload.length_bytes == 0)
        throw Error(ErrorCode::BadData, "upload " + upload.id + " is empty: it holds no dive");
    storage::NewDive dive{upload.id,
                          upload.project,
                          name_of(upload, plan),
                          plan.archive_sha256,
                          plan.content_sha256,
                          archive_key(upload),
                          upload.offset_bytes,
                          plan.preset,
                          services.limits.max_project_dives};
    if (upload.dive_id.empty()) {
        dive.archive_sha256 = archive_sha256(services, upload);
        if (!plan.archive_sha256.empty() && plan.archive_sha256 != dive.archive_sha256)
            throw Error(ErrorCode::BadData,
                        "the archive's sha256 is " + dive.archive_sha256 + ", not " +
                            plan.archive_sha256 + " as stated: delete the upload and send it anew");
        services.blobs.commit_staged(upload.blob, dive.blob);
    }
    const auto created = storage::DiveStore(catalog).create(dive);
    if (created.existed) services.blobs.remove(dive.blob);
    return {created.dive, !created.existed && upload.dive_id.empty(), created.job_id};
}

void make_owed_dives(const Services& services) {
    for (const Upload& upload : storage::UploadStore(services.catalog).list_open()) {
        try {
            const UploadPlan plan = plan_of(upload.metadata);
            if (!plan.commit || !upload.complete() || upload.is_partial()) continue;
            auto catalog = audited(services.catalog, "serve", "owed dive of " + upload.id);
            make_dive(services, catalog, upload, plan);
        } catch (const std::exception& error) {
            spdlog::warn(nlohmann::json{
                {"event", "dive_owed"}, {"upload", upload.id}, {"what", error.what()}}
                             .dump(-1, ' ', true, nlohmann::json::error_handler_t::replace));
        }
    }
}

}  // namespace divemesh::api
