#include "api/uploads/pending_dives.hpp"

#include <nlohmann/json.hpp>
#include <vector>

#include "api/audit.hpp"
#include "api/authorization.hpp"
#include "api/in_pool.hpp"
#include "api/uploads/concatenation.hpp"
#include "api/uploads/make_dive.hpp"
#include "api/uploads/make_truth.hpp"
#include "api/uploads/upload_writer.hpp"
#include "schemas/error.hpp"
#include "schemas/log.hpp"
#include "storage/token_store.hpp"
#include "storage/upload_store.hpp"

namespace divemesh::api {
namespace {

// Checks the token that began the upload: a revoked one must not get a dive by a restart.
void require_begun_by_right(const Services& services,
                            const Upload& upload,
                            const UploadPlan& plan) {
    if (upload.token_id.empty()) return;  // an import, or authentication is off
    const auto token = storage::TokenStore(services.catalog).get_valid(upload.token_id);
    if (!token)
        throw Error(ErrorCode::Unauthorized,
                    "the token that started this upload is no longer valid");
    require_scope(*token, "dives:write");
    if (!plan.preset.empty()) require_scope(*token, "jobs:write");
}

// Returns whether all bytes are here; the catalog may not yet know the last ones.
bool is_whole(const Services& services, const Upload& upload) {
    if (upload.complete() || upload.is_final() || !upload.length_bytes) return upload.complete();
    return services.blobs.staged_size_bytes(upload.blob) >= *upload.length_bytes;
}

std::vector<Upload> whole_uploads(const Services& services) {
    std::vector<Upload> uploads = storage::UploadStore(services.catalog).list_open();
    std::erase_if(uploads, [&](const Upload& upload) {
        return upload.is_partial() || !is_whole(services, upload);
    });
    return uploads;
}

// The caller holds the upload lock.
Awaitable<void> make_one(Services services, std::string upload_id) {
    auto read = [services, upload_id] {
        return reconciled(services, storage::UploadStore(services.catalog).get(upload_id));
    };
    const Upload upload = co_await in_pool(services.pool, std::move(read));
    const bool ended = upload.end.has_value();
    if (ended || !upload.complete() || upload.is_partial()) co_return;
    const UploadPlan plan = plan_of(upload.metadata);
    auto prepare = [services, upload, plan] {
        if (upload.is_final()) free_parts(services, upload);
        if (plan.commit) require_begun_by_right(services, upload, plan);
    };
    co_await in_pool(services.pool, std::move(prepare));
    if (!plan.commit || !upload.dive_id.empty()) co_return;
    const auto never = std::make_shared<std::atomic<bool>>(false);
    const std::string sha256 = co_await hash_archive(services, upload, never);
    auto make = [services, upload, plan, sha256] {
        auto catalog = audited(services.catalog, "serve", "pending dive of " + upload.id);
        try {
            if (plan.truth)
                make_truth(services, catalog, upload, plan, sha256);
            else
                make_dive(services, catalog, upload, plan, sha256);
        } catch (const Error& error) {
            const bool lost_its_dive = plan.truth && error.code() == ErrorCode::NotFound;
            if (error.code() != ErrorCode::BadData && !lost_its_dive) throw;
            storage::UploadStore(services.catalog).end(upload.id, UploadEnd::Terminated);
            free_bytes(services, upload);
            throw;
        }
    };
    co_await in_pool(services.transfers, std::move(make));
}

}  // namespace

Awaitable<PendingDives> make_pending_dives(Services services) {
    auto list = [services] { return whole_uploads(services); };
    const auto uploads = co_await in_pool(services.pool, std::move(list));
    bool is_any_busy = false;
    bool has_any_failed = false;
    for (const Upload& upload : uploads) {
        if (services.stopping) co_return PendingDives::Busy;
        const auto lock = co_await services.locks.take_if_free(upload.id);
        is_any_busy = is_any_busy || !lock;
        if (!lock) continue;
        std::string failure;
        try {
            co_await make_one(services, upload.id);
        } catch (const std::exception& error) {
            failure = error.what();
        }
        if (failure.empty()) continue;
        has_any_failed = true;
        log_warning({{"event", "pending_dive_failed"}, {"upload", upload.id}, {"what", failure}});
    }
    if (is_any_busy) co_return PendingDives::Busy;
    co_return has_any_failed ? PendingDives::Failed : PendingDives::Made;
}

}  // namespace divemesh::api
