#include "storage/wait_reasons.hpp"

#include "schemas/wait_reason.hpp"
#include "storage/catalog.hpp"
#include "storage/held_queues.hpp"
#include "storage/sql.hpp"
#include "storage/worker_store.hpp"

namespace divemesh::storage {
namespace {

struct WorkerRow {
    int num_slots = 0;
    int draining = 0;
    std::string waits_for;

    void define(soci::statement& statement) {
        define_columns(statement, num_slots, draining, waits_for);
    }
    WorkerRow value() const { return *this; }
};

std::set<std::string> projects_of(soci::session& session, const std::string& queues) {
    const auto names = select_all<TextRow>(session, "SELECT project FROM " + queues + " AS held");
    return {names.begin(), names.end()};
}

std::string word(WaitReason reason) { return std::string(to_string(reason)); }

}  // namespace

WaitReasons::WaitReasons(soci::session& session)
    : now_ms_(Catalog::now_ms(session)),
      paused_(projects_of(session, kPausedQueues)),
      full_(projects_of(session, kFullQueues)) {
    of_queue_ = of_workers(session);
    if (paused_.contains("")) of_queue_ = word(WaitReason::QueuePaused);
}

std::string WaitReasons::of_workers(soci::session& session) {
    const std::int64_t alive_since_ms = now_ms_ - kWorkerSilence_ms;
    std::string reason = word(WaitReason::Worker);
    for (const WorkerRow& worker : select_all<WorkerRow>(
             session,
             "SELECT num_slots, draining, waits_for FROM workers WHERE seen_at_ms >= :alive"
             " ORDER BY draining DESC, name",
             soci::use(alive_since_ms, "alive"))) {
        reason = worker.draining != 0 ? word(WaitReason::Drain) : worker.waits_for;
        if (reason.empty()) num_slots_ += worker.num_slots;
    }
    return num_slots_ > 0 ? "" : reason;
}

std::string WaitReasons::of(const Job& job) const {
    if (job.state == JobState::Held) return reason_of_held(job);
    if (job.state != JobState::Queued) return "";
    if (paused_.contains("") || paused_.contains(job.project)) return word(WaitReason::QueuePaused);
    if (!of_queue_.empty()) return of_queue_;
    if (job.kind != JobKind::Intake && (full_.contains("") || full_.contains(job.project)))
        return word(WaitReason::Limit);
    return job.not_before_ms > now_ms_ ? word(WaitReason::Retry) : "";
}

std::string reason_of_held(const Job& job) {
    return word(job.paused ? WaitReason::Paused : WaitReason::Parent);
}

ShownJob with_wait_reason(soci::session& session, const Job& job) {
    ShownJob shown;
    static_cast<Job&>(shown) = job;
    if (job.state == JobState::Held) shown.waits_for = reason_of_held(job);
    if (job.state == JobState::Queued) shown.waits_for = WaitReasons(session).of(job);
    return shown;
}

}  // namespace divemesh::storage
