#include "worker/runner/worker_gate.hpp"

#include <utility>

#include "schemas/log.hpp"
#include "schemas/wait_reason.hpp"
#include "storage/data_id.hpp"
#include "worker/runner/disk_room.hpp"

namespace divemesh::runner {

std::string WorkerGate::waits_for() {
    std::string reason;
    std::string what = "less than --min-free is left in " + config_.work_folder.string();
    if (!DiskRoom(config_).make(kMinScratch_bytes)) reason = to_string(WaitReason::Disk);
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
                                       bool has_filled_the_disk) {
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
    const bool may_be_full = !has_filled_the_disk && (failure.code == ErrorCode::OutOfSpace ||
                                                      failure.code == ErrorCode::Unavailable);
    if (waits_for == to_string(WaitReason::Disk) && may_be_full)
        return Failure{.code = ErrorCode::OutOfSpace,
                       .message = "the worker's disk is full: " + failure.message,
                       .remedy = "free space on it: the job then runs by itself"};
    return std::nullopt;
}

}  // namespace divemesh::runner
