#include "api/uploads/make_dive.hpp"

#include <vector>

#include "api/in_pool.hpp"
#include "schemas/error.hpp"
#include "storage/dive_store.hpp"

namespace divemesh::api {
namespace {

constexpr std::size_t kReadBytes = std::size_t{1} << 20;
constexpr int kReadsAtATime = 32;  // in the pool, before other work may run

class ArchiveHash {
public:
    ArchiveHash(const Services& services, const Upload& upload) {
        if (auto known = services.hashes.take(upload.id, upload.offset_bytes)) {
            hash_ = std::move(*known);
            return;
        }
        const std::string key = archive_key(upload);
        // If the server was killed before the catalog knew, the bytes are already under the key of
        // the dive's blob.
        reader_ = services.blobs.exists(key) ? services.blobs.open(key)
                                             : services.blobs.read_staged(upload.blob);
        buffer_.resize(kReadBytes);
    }

    // Returns false when all of it is hashed.
    bool hash_some() {
        for (int i = 0; i < kReadsAtATime && reader_; ++i) {
            const std::size_t n = reader_->read_at(offset_, buffer_);
            hash_.update({buffer_.data(), n});
            offset_ += static_cast<std::int64_t>(n);
            if (n == 0) reader_.reset();
        }
        return reader_ != nullptr;
    }
    std::string hex() { return hash_.hex(); }

private:
    Sha256 hash_;
    std::unique_ptr<storage::BlobReader> reader_;  // null: all of it is read
    std::vector<char> buffer_;
    std::int64_t offset_ = 0;
};

std::string name_of(const Upload& upload, const UploadPlan& plan) {
    return plan.name.empty() ? upload.id : plan.name;
}

}  // namespace

std::string archive_key(const Upload& upload) {
    return plan_of(upload.metadata).truth ? "truth/" + upload.id + "/file"
                                          : "dives/" + upload.id + "/archive";
}

Awaitable<std::string> hash_archive(Services services, Upload upload, StopFlag stopped) {
    const bool is_archive = upload.complete() && !upload.is_partial() && upload.offset_bytes > 0;
    if (!is_archive || !upload.dive_id.empty()) co_return "";
    auto begin = [services, upload] { return std::make_shared<ArchiveHash>(services, upload); };
    const auto hash = co_await in_pool(services.pool, std::move(begin));
    for (bool more = true; more;) {
        if (*stopped) throw Error(ErrorCode::Conflict, "a newer request took over this upload");
        if (services.stopping)
            throw Error(ErrorCode::Unavailable, "the server is stopping: try again");
        auto some = [hash] { return hash->hash_some(); };
        more = co_await in_pool(services.pool, std::move(some));
    }
    co_return hash->hex();
}

void require_whole(const Upload& upload, const UploadPlan& plan, const std::string& sha256) {
    if (!upload.complete())
        throw Error(ErrorCode::Conflict,
                    "upload " + upload.id + " has " + std::to_string(upload.offset_bytes) + " of " +
                        (upload.length_bytes ? std::to_string(*upload.length_bytes) : "unknown") +
                        " bytes: send the rest first");
    if (upload.is_partial())
        throw Error(ErrorCode::Conflict,
                    "upload " + upload.id + " is a part: create the final upload first");
    if (upload.length_bytes == 0)
        throw Error(ErrorCode::BadData,
                    "upload " + upload.id + " is empty: send the recording first");
    const bool is_bound = !upload.dive_id.empty();
    if (!is_bound && !plan.archive_sha256.empty() && plan.archive_sha256 != sha256)
        throw Error(ErrorCode::BadData,
                    "the archive's sha256 is " + sha256 + ", not " + plan.archive_sha256 +
                        " as stated: delete the upload and send it again");
}

MadeDive make_dive(const Services& services,
                   storage::Catalog& catalog,
                   const Upload& upload,
                   const UploadPlan& plan,
                   const std::string& sha256) {
    require_whole(upload, plan, sha256);
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
        dive.archive_sha256 = sha256;
        services.blobs.commit_staged(upload.blob, dive.blob);
    }
    const auto created = storage::DiveStore(catalog).create(dive);
    if (created.existed) services.blobs.remove(dive.blob);
    return {created.dive, !created.existed && upload.dive_id.empty(), created.job_id};
}

}  // namespace divemesh::api
