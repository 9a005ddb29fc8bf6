#include "api/uploads/make_truth.hpp"

#include "api/uploads/make_dive.hpp"
#include "schemas/error.hpp"
#include "storage/truth_store.hpp"

namespace divemesh::api {
namespace {

constexpr int kPerRound = 100;

}  // namespace

TruthFile make_truth(const Services& services,
                     storage::Catalog& catalog,
                     const Upload& upload,
                     const UploadPlan& plan,
                     const std::string& sha256) {
    require_whole(upload, plan, sha256);
    const storage::NewTruth wanted{.upload_id = upload.id,
                                   .project = upload.project,
                                   .dive_id = plan.dive_id,
                                   .kind = plan.truth.value(),
                                   .name = plan.name.empty() ? upload.id : plan.name,
                                   .sha256 = sha256,
                                   .size_bytes = upload.offset_bytes,
                                   .blob = archive_key(upload)};
    if (upload.dive_id.empty()) services.blobs.commit_staged(upload.blob, wanted.blob);
    const auto created = storage::TruthStore(catalog).create(wanted);
    if (created.existed) services.blobs.remove(wanted.blob);
    return created.file;
}

void remove_deleted_truth(const Services& services) {
    storage::TruthStore truths(services.catalog);
    for (const TruthFile& file : truths.removed(kPerRound)) {
        services.blobs.remove_prefix(file.blob.substr(0, file.blob.rfind('/') + 1));
        truths.forget(file.id);
    }
}

}  // namespace divemesh::api
