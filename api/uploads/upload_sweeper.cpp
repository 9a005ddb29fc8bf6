#include "api/uploads/upload_sweeper.hpp"

#include <nlohmann/json.hpp>

#include "api/in_pool.hpp"
#include "api/uploads/upload_writer.hpp"
#include "schemas/log.hpp"
#include "storage/idempotency_store.hpp"
#include "storage/upload_store.hpp"

namespace divemesh::api {
namespace {

constexpr std::chrono::milliseconds kRememberEnded = std::chrono::hours(30 * 24);
constexpr std::chrono::milliseconds kRememberAnswers = std::chrono::hours(48);

void log_failure(const std::string& upload_id, const std::exception& error) {
    log_warning({{"event", "sweep_failed"}, {"upload", upload_id}, {"what", error.what()}});
}

// Runs `work` with the upload lock, unless a request holds it.
template <typename Work>
Awaitable<void> when_free(Services services, std::string upload_id, Work work) {
    const auto lock = co_await services.locks.take_if_free(upload_id);
    if (!lock) co_return;
    auto guarded = [upload_id, work] {
        try {
            work();
        } catch (const std::exception& error) {
            log_failure(upload_id, error);
        }
    };
    co_await in_pool(services.pool, std::move(guarded));
}

}  // namespace

Awaitable<void> sweep_uploads(Services services) {
    auto list_expired = [services] {
        return storage::UploadStore(services.catalog).list_expired();
    };
    const auto expired = co_await in_pool(services.pool, std::move(list_expired));
    for (const std::string& id : expired) {
        auto expire = [services, id] { storage::UploadStore(services.catalog).expire(id); };
        co_await when_free(services, id, std::move(expire));
    }
    auto list_ended = [services] { return storage::UploadStore(services.catalog).list_unfreed(); };
    const auto ended = co_await in_pool(services.pool, std::move(list_ended));
    for (const Upload& upload : ended) {
        auto free = [services, upload] { free_bytes(services, upload); };
        co_await when_free(services, upload.id, std::move(free));
    }
    auto forget = [services] {
        storage::UploadStore(services.catalog).forget_ended(kRememberEnded.count());
        storage::IdempotencyStore(services.catalog).forget(kRememberAnswers.count());
    };
    co_await in_pool(services.pool, std::move(forget));
}

}  // namespace divemesh::api
