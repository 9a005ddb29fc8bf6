#include "worker/runner/worker_gate.hpp"

#include <utility>

#include "schemas/log.hpp"
#include "schemas/wait_reason.hpp"
#include "storage/data_id.hpp"
#include "worker/runner/disk_room.hpp"

namespace divemesh::runner {

namespace {

// Returns true where the free space cannot be read: then the blob store is what is missing.
bool has_room_for_results(const WorkerConfig& config, storage::BlobStore& blobs) {
    try {
        return blobs.free_bytes() >= config.min_free_bytes;
    } catch (const Error&) {
        return true;
    }
}

}  // namespace

std::string WorkerGate::waits_for() {
    std::string reason;
    std::string what = "less than --min-free is left in " + config_.work_folder.string();
    if (!DiskRoom(config_).make(kMinScratch_bytes)) {
        reason = to_string(WaitReason::Disk);
    } else if (!has_room_for_results(config_, blobs_)) {
        reason = to_string(WaitReason::Disk);
        what = "less than --min-free is left in " + blobs_.location();
    }
    if (std::string mismatch = storage::data_mismatch(catalog_, blobs_); !mismatch.empty()) {
        reason = to_string(WaitReason::Storage);
        what = std::move(mismatch);
    }
    const std::lock_guard lock(mutex_);
    if (reason == last_) return reason;
    last_ = reason;
    if (reason.empty())
        log_info({{"event", "worker_goes_on"}});
    else
        log_warning({{"event", "worker_waits"}, {"for", reason}, {"what", what}});
    return reason;
}

std::optional<Failure> fault_of_worker(WorkerGate& gate,
                                       const Failure& failure,
                                       bool attempt_is_to_blame) {
    if (failure.code == ErrorCode::Cancelled) return std::nullopt;
    std::string waits_for;
    try {
        waits_for = gate.waits_for();
    } catch (const std::exception&) {  // the catalog is unreachable, and the failure not written
    }
    if (waits_for == to_string(WaitReason::Storage))
        return Failure{.code = ErrorCode::Unavailable,
                       .message = "the worker lost its blob store: " + failure.message,
                       .remedy = "mount its disk again: the job then runs by itself"};
    const bool may_be_full = !attempt_is_to_blame && (failure.code == ErrorCode::OutOfSpace ||
                                                      failure.code == ErrorCode::Unavailable);
    if (waits_for == to_string(WaitReason::Disk) && may_be_full)
        return Failure{.code = ErrorCode::OutOfSpace,
                       .message = "the worker's disk is full: " + failure.message,
                       .remedy = "free space on it: the job then runs by itself"};
    return std::nullopt;
}

}  // namespace divemesh::runner
