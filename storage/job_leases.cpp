// What workers do to jobs: everything here happens under a lease.
#include <algorithm>
#include <random>

#include "schemas/error.hpp"
#include "schemas/json.hpp"
#include "storage/dive_rows.hpp"
#include "storage/ids.hpp"
#include "storage/job_changes.hpp"
#include "storage/job_rows.hpp"
#include "storage/job_store.hpp"
#include "storage/sql.hpp"

namespace divemesh::storage {
namespace {

constexpr std::size_t kMaxLogBytes = 256 * 1024;
constexpr const char* kLogCut = "\n[the log was cut off here]\n";

constexpr const char* kHasDueOrExpired =
    "SELECT COUNT(*) FROM (SELECT 1 FROM jobs WHERE"
    " (state = 'queued' AND not_before_ms <= :now) OR"
    " (state = 'running' AND lease_expires_at_ms <= :now) LIMIT 1) AS work";

bool is_bad_data(ErrorCode code) {
    return code == ErrorCode::BadData || code == ErrorCode::InvalidArgument ||
           code == ErrorCode::TooLarge || code == ErrorCode::Unsupported;
}

// Doubles with every attempt, and differs between jobs that failed together (a database or a disk
// that was gone for a moment).
std::int64_t pause_ms(const RetryPause& pause, int num_attempts) {
    static thread_local std::mt19937_64 random{std::random_device{}()};
    const int doublings = std::clamp(num_attempts - 1, 0, 20);
    const auto full =
        std::min<std::int64_t>(pause.first.count() << doublings, pause.longest.count());
    return std::uniform_int_distribution<std::int64_t>(full / 2, full)(random);
}

// A worker was killed, froze or lost the network.
AttemptEnd end_of_expired(const Job& job) {
    const Failure failure{.code = ErrorCode::Unavailable,
                          .message =
                              "the worker was not heard of before its lease ended: it was "
                              "killed, or lost its network"};
    AttemptEnd end{.attempt = AttemptState::LeaseLost, .job = JobState::Queued, .failure = failure};
    if (job.cancel_requested)
        end.job = JobState::Cancelled;
    else if (job.num_attempts >= job.max_attempts)
        end.job = JobState::Dead;
    return end;
}

int end_expired(soci::session& session) {
    const std::int64_t now_ms = Catalog::now_ms(session);
    const auto expired =
        select_all<JobRow>(session,
                           "SELECT " + std::string(kJobColumns) +
                               " FROM jobs WHERE state = 'running' AND lease_expires_at_ms <= :now"
                               " ORDER BY created_at_ms, id",
                           soci::use(now_ms, "now"));
    for (const Job& job : expired) end_attempt(session, job, end_of_expired(job));
    return static_cast<int>(expired.size());
}

// The first job by priority and age that is due, taken over in one statement.
std::optional<Lease> take_next(soci::session& session, std::chrono::milliseconds duration) {
    struct LeaseRow {
        Lease lease;
        void define(soci::statement& statement) {
            statement.exchange(soci::into(lease.job_id));
            statement.exchange(soci::into(lease.attempt));
            statement.exchange(soci::into(lease.lease_id));
        }
        Lease value() const { return lease; }
    };
    const std::int64_t now_ms = Catalog::now_ms(session);
    const std::int64_t expires_at_ms = now_ms + duration.count();
    const std::string lease_id = random_hex(16);
    return select_one<LeaseRow>(
        session,
        "UPDATE jobs SET state = 'running', attempt = attempt + 1, num_attempts = num_attempts + 1,"
        " lease_id = :lease, lease_expires_at_ms = :expires, started_at_ms = :now,"
        " failure_code = '', failure_message = '', not_before_ms = 0"
        " WHERE id = (SELECT id FROM jobs WHERE state = 'queued' AND not_before_ms <= :now"
        "   ORDER BY priority DESC, created_at_ms, id LIMIT 1)"
        " RETURNING id, attempt, lease_id",
        soci::use(lease_id, "lease"),
        soci::use(expires_at_ms, "expires"),
        soci::use(now_ms, "now"));
}

void insert_attempt(soci::session& session, const Lease& lease, const std::string& worker) {
    const std::int64_t now_ms = Catalog::now_ms(session);
    execute(session,
            "INSERT INTO attempts (job_id, number, worker, started_at_ms)"
            " VALUES (:job, :number, :worker, :now)",
            soci::use(lease.job_id, "job"),
            soci::use(lease.attempt, "number"),
            soci::use(worker, "worker"),
            soci::use(now_ms, "now"));
}

void insert_artifact(soci::session& session, const Lease& lease, const Artifact& artifact) {
    execute(session,
            "INSERT INTO artifacts (job_id, name, media_type, sha256, size_bytes, blob)"
            " VALUES (:job, :name, :type, :hash, :bytes, :blob)",
            soci::use(lease.job_id, "job"),
            soci::use(artifact.name, "name"),
            soci::use(artifact.media_type, "type"),
            soci::use(artifact.sha256, "hash"),
            soci::use(artifact.size_bytes, "bytes"),
            soci::use(artifact.blob, "blob"));
}

// Who cancelled a job does not want it tried again, whatever it failed of. An attempt that says
// cancelled without anybody having asked was ended from outside: that is retried.
AttemptEnd end_of_failed(const Job& job, const Failure& failure, std::int64_t retry_at_ms) {
    AttemptEnd end{.attempt = AttemptState::Failed, .failure = failure};
    if (is_bad_data(failure.code)) {
        end.job = JobState::Failed;
    } else if (job.cancel_requested) {
        end.attempt = AttemptState::Cancelled;
        end.job = JobState::Cancelled;
    } else if (job.num_attempts >= job.max_attempts) {
        end.job = JobState::Dead;
    } else {
        end.job = JobState::Queued;
        end.not_before_ms = retry_at_ms;
    }
    return end;
}

// An intake that cannot say what is wrong in findings still decides about its dive.
void refuse_dive(soci::session& session, const Job& job, const Failure& failure) {
    IntakeResult result;
    result.findings.push_back({.severity = Severity::Error,
                               .code = "intake_failed",
                               .message = failure.message,
                               .remedy = "check the recording with `divemesh validate`"});
    apply_intake(session, job.dive_id, result);
}

}  // namespace

// Runs `write` on the leased job in one transaction; false when the lease is stale.
bool JobStore::with_lease(const Lease& lease,
                          const std::function<void(soci::session&, const Job&)>& write) {
    bool valid = false;
    catalog_.transaction([&](soci::session& session) {
        const auto job = lock_leased_job(session, lease);
        valid = job.has_value();
        if (valid) write(session, *job);
    });
    return valid;
}

std::optional<Claim> JobStore::claim(const std::string& worker, std::chrono::milliseconds lease) {
    int due = 0;  // looked for without the writers' lock: most polls find nothing
    catalog_.read([&](soci::session& session) {
        const std::int64_t now_ms = Catalog::now_ms(session);
        session << kHasDueOrExpired, soci::use(now_ms, "now"), soci::into(due);
    });
    if (due == 0) return std::nullopt;

    std::optional<Claim> claim;
    catalog_.transaction([&](soci::session& session) {
        end_expired(session);
        const auto taken = take_next(session, lease);
        if (!taken) return;
        insert_attempt(session, *taken, worker);
        append_job_event(session, taken->job_id, "job.state");
        claim = Claim{.job = read_job(session, taken->job_id), .lease = *taken};
        claim->dive = read_dive(session, claim->job.dive_id);
    });
    return claim;
}

Renewal JobStore::renew(const Lease& lease, std::chrono::milliseconds duration) {
    Renewal renewal;
    renewal.valid = with_lease(lease, [&](soci::session& session, const Job& job) {
        const std::int64_t expires_at_ms = Catalog::now_ms(session) + duration.count();
        execute(session,
                "UPDATE jobs SET lease_expires_at_ms = :expires WHERE id = :id",
                soci::use(expires_at_ms, "expires"),
                soci::use(job.id, "id"));
        renewal.cancel_requested = job.cancel_requested;
    });
    return renewal;
}

Renewal JobStore::look(const Lease& lease) {
    Renewal renewal;
    catalog_.read([&](soci::session& session) {
        const auto job = find_leased_job(session, lease);
        renewal = {.valid = job.has_value(), .cancel_requested = job && job->cancel_requested};
    });
    return renewal;
}

bool JobStore::report_progress(const Lease& lease, const Progress& progress) {
    const std::string text = to_text(progress);
    return with_lease(lease, [&](soci::session& session, const Job& job) {
        execute(session,
                "UPDATE jobs SET progress = :progress WHERE id = :id",
                soci::use(text, "progress"),
                soci::use(job.id, "id"));
        append_job_event(session, job.id, "job.progress");
    });
}

bool JobStore::append_log(const Lease& lease, const std::string& text) {
    return with_lease(lease, [&](soci::session& session, const Job& job) {
        const std::string log = select_one<TextRow>(session,
                                                    "SELECT log FROM attempts WHERE job_id = :job"
                                                    " AND state = 'running'",
                                                    soci::use(job.id, "job"))
                                    .value_or("");
        if (log.size() >= kMaxLogBytes) return;
        std::string added = text.substr(0, kMaxLogBytes - log.size());
        if (log.size() + text.size() >= kMaxLogBytes) added += kLogCut;
        execute(session,
                "UPDATE attempts SET log = log || :added WHERE job_id = :job AND state = 'running'",
                soci::use(added, "added"),
                soci::use(job.id, "job"));
    });
}

bool JobStore::succeed(const Lease& lease, const std::vector<Artifact>& artifacts) {
    return with_lease(lease, [&](soci::session& session, const Job& job) {
        for (const Artifact& artifact : artifacts) insert_artifact(session, lease, artifact);
        end_attempt(session, job, {});
    });
}

bool JobStore::finish_intake(const Lease& lease, const IntakeResult& result) {
    return with_lease(lease, [&](soci::session& session, const Job& job) {
        const IntakeVerdict verdict = apply_intake(session, job.dive_id, result);
        end_attempt(session, job, {});
        settle_children(session, job.id, verdict.refusal);
    });
}

bool JobStore::fail(const Lease& lease, const Failure& failure) {
    return with_lease(lease, [&](soci::session& session, const Job& job) {
        const std::int64_t retry_at_ms =
            Catalog::now_ms(session) + pause_ms(pause_, job.num_attempts);
        const AttemptEnd end = end_of_failed(job, failure, retry_at_ms);
        if (job.kind == JobKind::Intake && end.job == JobState::Failed)
            refuse_dive(session, job, failure);
        end_attempt(session, job, end);
    });
}

bool JobStore::release(const Lease& lease) {
    return with_lease(lease, [&](soci::session& session, const Job& job) {
        end_attempt(session,
                    job,
                    {.attempt = AttemptState::Released,
                     .job = job.cancel_requested ? JobState::Cancelled : JobState::Queued,
                     .counts = false});
    });
}

int JobStore::requeue_expired() {
    int num_expired = 0;
    catalog_.transaction([&](soci::session& session) { num_expired = end_expired(session); });
    return num_expired;
}

}  // namespace divemesh::storage
