#include "api/readiness.hpp"

#include <exception>

#include "api/disk_guard.hpp"
#include "api/services.hpp"
#include "schemas/error.hpp"
#include "storage/data_id.hpp"
#include "storage/ids.hpp"
#include "storage/queue_store.hpp"

namespace divemesh::api {
namespace {

using namespace std::chrono_literals;

constexpr std::string_view kProbe = "ready";

void probe_blobs(storage::BlobStore& blobs) {
    const std::string key = "uploads/probe-" + storage::random_hex(8);
    const auto staged = blobs.open_staged(key);
    staged->write(kProbe);
    const auto written = staged->flush();
    blobs.remove_staged(key);
    if (written != std::ssize(kProbe))
        throw Error(ErrorCode::Unavailable, "the data written cannot be read back");
}

// Returns "" or what went wrong.
template <typename Check>
std::string failure_of(const std::string& name, const Check& check) {
    try {
        check();
        return "";
    } catch (const std::exception& error) {
        return name + ": " + error.what();
    }
}

}  // namespace

Readiness::Result Readiness::check(const Services& services) {
    const std::int64_t min_free_bytes = services.limits.min_free_bytes;
    // One check at a time asks the stores: where they do not answer, others must not wait as well.
    std::unique_lock asking(asking_, std::defer_lock);
    if (const auto last = last_result(); !last)
        asking.lock();
    else if (!asking.try_lock())
        return *last;
    if (std::chrono::steady_clock::now() < next_poll_) return *last_result();
    Result result;
    result.failure = failure_of("catalog", [&] { services.catalog.require_writable(); });
    if (result.failure.empty())
        result.failure = failure_of("blob store", [&] {
            storage::require_same_data(services.catalog, services.blobs);
            probe_blobs(services.blobs);
        });
    if (result.failure.empty())
        result.failure = failure_of("disk", [&] {
            result.free_bytes = reachable_bytes(services, min_free_bytes);
            if (result.free_bytes < min_free_bytes)
                throw Error(ErrorCode::OutOfSpace,
                            std::to_string(result.free_bytes >> 20) +
                                " MiB are free, less than the " +
                                std::to_string(min_free_bytes >> 20) +
                                " MiB to keep free: free some space");
        });
    if (result.failure.empty())
        result.failure = failure_of("queue", [&] {
            result.queue_waits_for = storage::QueueStore(services.catalog).waits_for();
        });
    next_poll_ = std::chrono::steady_clock::now() + 1s;
    const std::lock_guard lock(mutex_);
    last_ = result;
    return result;
}

std::optional<Readiness::Result> Readiness::last_result() {
    const std::lock_guard lock(mutex_);
    return last_;
}

}  // namespace divemesh::api
