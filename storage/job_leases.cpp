// What workers do to jobs: all of it needs a lease.
#include "schemas/error.hpp"
#include "schemas/json.hpp"
#include "storage/dive_rows.hpp"
#include "storage/event_store.hpp"
#include "storage/held_queues.hpp"
#include "storage/ids.hpp"
#include "storage/job_changes.hpp"
#include "storage/job_ends.hpp"
#include "storage/job_rows.hpp"
#include "storage/job_speeds.hpp"
#include "storage/job_store.hpp"
#include "storage/metric_store.hpp"
#include "storage/report_jobs.hpp"
#include "storage/sql.hpp"
#include "storage/stage_seconds.hpp"

namespace divemesh::storage {
namespace {

// Limits for what an attempt reports, because its recording may have taken it over.
constexpr std::size_t kMaxLogBytes = std::size_t{256} << 10;
constexpr std::size_t kMaxStages = 32;
constexpr std::size_t kMaxFindings = 200;
constexpr std::size_t kMaxFindingBytes = 4096;  // of each of its texts
constexpr std::size_t kMaxStageNameBytes = 64;
constexpr const char* kLogCut = "\n[the log was cut off here]\n";

// A retry is never due later than :max_pause from now. If it seems so, the clock was set back.
const std::string kStartable =
    " FROM jobs WHERE state = 'queued'"
    " AND (not_before_ms <= :now OR not_before_ms - :max_pause > :now)"
    " AND '' NOT IN " +
    kPausedQueues + " AND project NOT IN " + kPausedQueues +
    " AND (kind = 'intake' OR ('' NOT IN " + kFullQueues + " AND project NOT IN " + kFullQueues +
    "))"
    " AND NOT EXISTS (SELECT 1 FROM workers WHERE name = :worker AND draining = 1)";

// Expired, or ending later than any lease of its length can: then the clock was set back.
const std::string kEndingWrong =
    " FROM jobs WHERE state = 'running'"
    " AND (lease_expires_at_ms <= :now OR lease_expires_at_ms > :now + lease_ms)";

bool has_work(soci::session& session, const std::string& worker, std::int64_t max_pause_ms) {
    const std::int64_t now_ms = Catalog::now_ms(session);
    const auto work = select_one<TextRow>(session,
                                          "SELECT '' WHERE EXISTS (SELECT 1" + kStartable +
                                              ") OR EXISTS (SELECT 1" + kEndingWrong + ")",
                                          soci::use(now_ms, "now"),
                                          soci::use(max_pause_ms, "max_pause"),
                                          soci::use(worker, "worker"));
    return work.has_value();
}

bool has_lost_jobs(soci::session& session) {
    const std::int64_t now_ms = Catalog::now_ms(session);
    return select_one<TextRow>(session,
                               "SELECT '' WHERE EXISTS (SELECT 1" + kEndingWrong + ")",
                               soci::use(now_ms, "now"))
        .has_value();
}

int end_expired(soci::session& session) {
    const std::int64_t now_ms = Catalog::now_ms(session);
    execute(session,
            "UPDATE jobs SET lease_expires_at_ms = :now + lease_ms"
            " WHERE state = 'running' AND lease_expires_at_ms > :now + lease_ms",
            soci::use(now_ms, "now"));
    const auto expired = select_all<ExpiredRow>(
        session,
        "SELECT " + kExpiredColumns +
            " FROM jobs WHERE state = 'running' AND lease_expires_at_ms <= :now"
            " ORDER BY created_at_ms, id",
        soci::use(now_ms, "now"));
    for (const ExpiredJob& lost : expired) end_attempt(session, lost.job, end_of_expired(lost));
    return static_cast<int>(expired.size());
}

// Takes the first due job by priority and age in one statement.
std::optional<Lease> take_next(soci::session& session,
                               const std::string& worker,
                               std::chrono::milliseconds duration,
                               std::int64_t max_pause_ms) {
    struct LeaseRow {
        Lease lease;
        void define(soci::statement& statement) {
            define_columns(statement, lease.job_id, lease.attempt, lease.lease_id);
        }
        Lease value() const { return lease; }
    };
    const std::int64_t now_ms = Catalog::now_ms(session);
    const std::int64_t lease_ms = duration.count();
    const std::int64_t expires_ms = now_ms + lease_ms;
    const std::string lease_id = random_hex(16);
    return select_one<LeaseRow>(
        session,
        "UPDATE jobs SET state = 'running', attempt = attempt + 1, num_attempts = num_attempts + 1,"
        " lease_id = :lease, lease_expires_at_ms = :expires, lease_ms = :duration,"
        " lease_renewed = 0, started_at_ms = :now, stages = '[]', failure_code = '',"
        " failure_message = '', failure_remedy = '', not_before_ms = 0"
        " WHERE id = (SELECT id" +
            kStartable +
            " ORDER BY queue_rank_ms, id LIMIT 1)"
            " RETURNING id, attempt, lease_id",
        soci::use(lease_id, "lease"),
        soci::use(expires_ms, "expires"),
        soci::use(lease_ms, "duration"),
        soci::use(now_ms, "now"),
        soci::use(max_pause_ms, "max_pause"),
        soci::use(worker, "worker"));
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

void write_requirements(soci::session& session,
                        const Job& job,
                        const std::vector<RequirementResult>& requirements) {
    if (requirements.empty()) return;
    const std::string text = to_text(requirements);
    execute(session,
            "UPDATE jobs SET requirements = :requirements WHERE id = :id",
            soci::use(text, "requirements"),
            soci::use(job.id, "id"));
}

// Keeps the findings on a reconstruction, and its verdict. Their number and length are limited,
// because a recording may have taken over what reports them.
void write_verdict(soci::session& session, const Job& job, const Measurement& measured) {
    if (!measured.verdict) return;
    std::vector<Finding> kept = measured.findings;
    if (kept.size() > kMaxFindings) kept.resize(kMaxFindings);
    for (Finding& finding : kept)
        for (std::string* text : {&finding.code, &finding.where, &finding.message, &finding.remedy})
            if (text->size() > kMaxFindingBytes) text->resize(kMaxFindingBytes);
    const std::string verdict(to_string(*measured.verdict));
    const std::string findings = to_text(kept);
    execute(session,
            "UPDATE jobs SET verdict = :verdict, findings = :findings WHERE id = :id",
            soci::use(verdict, "verdict"),
            soci::use(findings, "findings"),
            soci::use(job.id, "id"));
}

// Makes the files of a failed attempt artifacts of its job, until the job is tried again.
void keep_partial_result(soci::session& session,
                         const Lease& lease,
                         const Job& job,
                         const PartialResult& partial) {
    for (const Artifact& artifact : partial.artifacts) insert_artifact(session, lease, artifact);
    write_verdict(session, job, partial.measured);
    execute(session,
            "UPDATE attempts SET cleaned = 1 WHERE job_id = :job AND number = :number",
            soci::use(lease.job_id, "job"),
            soci::use(lease.attempt, "number"));
}

void append_regression_event(soci::session& session,
                             const Job& job,
                             const std::vector<Regression>& regressions) {
    EventStore::append(session,
                       {.project = job.project,
                        .topic = "job",
                        .subject = job.id,
                        .type = "job.figure_worse",
                        .data = {{"job_id", job.id},
                                 {"dive_id", job.dive_id},
                                 {"tag", job.options.value("tag", "")},
                                 {"regressions", regressions}}});
}

// Refuses the dive of an intake that failed without findings.
void refuse_dive(soci::session& session, const Job& job, const Failure& failure) {
    IntakeResult result;
    result.findings.push_back({.severity = Severity::Error,
                               .code = "intake_failed",
                               .message = failure.message,
                               .remedy = "check the recording with `divemesh validate`"});
    apply_intake(session, job.dive_id, result);
}

}  // namespace

// Runs `write` on the leased job in one transaction. Returns false if the lease is stale.
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
    const std::int64_t max_pause_ms = pause_.max.count();
    bool found = false;  // read without the write lock, because most polls find no job
    catalog_.read([&](soci::session& session) { found = has_work(session, worker, max_pause_ms); });
    if (!found) return std::nullopt;

    std::optional<Claim> claim;
    catalog_.transaction([&](soci::session& session) {
        end_expired(session);
        const auto taken = take_next(session, worker, lease, max_pause_ms);
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
        const std::int64_t lease_ms = duration.count();
        const std::int64_t expires_ms = Catalog::now_ms(session) + lease_ms;
        execute(session,
                "UPDATE jobs SET lease_expires_at_ms = :expires, lease_ms = :duration,"
                " lease_renewed = 1 WHERE id = :id",
                soci::use(expires_ms, "expires"),
                soci::use(lease_ms, "duration"),
                soci::use(job.id, "id"));
        renewal.cancel_requested = job.cancel_requested;
    });
    return renewal;
}

Renewal JobStore::check_lease(const Lease& lease) {
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

bool JobStore::report_stage(const Lease& lease, const StageRun& stage) {
    return with_lease(lease, [&](soci::session& session, const Job& job) {
        std::vector<StageRun> stages = job.stages;
        if (stages.size() >= kMaxStages || stage.name.size() > kMaxStageNameBytes) return;
        stages.push_back(stage);
        const std::string text = to_text(stages);
        execute(session,
                "UPDATE jobs SET stages = :stages WHERE id = :id",
                soci::use(text, "stages"),
                soci::use(job.id, "id"));
        count_stage(session, stage);
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

bool JobStore::succeed(const Lease& lease,
                       const std::vector<Artifact>& artifacts,
                       const Measurement& measured) {
    return with_lease(lease, [&](soci::session& session, const Job& job) {
        for (const Artifact& artifact : artifacts) insert_artifact(session, lease, artifact);
        insert_metrics(session, job, measured);
        write_requirements(session, job, measured.requirements);
        write_verdict(session, job, measured);
        learn_speed(session, job);
        end_attempt(session, job, {});
        if (!measured.regressions.empty())
            append_regression_event(session, job, measured.regressions);
    });
}

bool JobStore::finish_intake(const Lease& lease, const IntakeResult& result) {
    return with_lease(lease, [&](soci::session& session, const Job& job) {
        const IntakeVerdict verdict = apply_intake(session, job.dive_id, result);
        learn_speed(session, job);
        end_attempt(session, job, {});
        settle_children(session, job.id, verdict.refusal);
    });
}

bool JobStore::fail(const Lease& lease,
                    const Failure& failure,
                    const std::optional<UnreadableTruth>& unreadable,
                    const PartialResult& partial) {
    return with_lease(lease, [&](soci::session& session, const Job& job) {
        const bool other_truth = unreadable && set_truth_aside(session, job, *unreadable);
        const std::int64_t retry_at_ms =
            Catalog::now_ms(session) + pause_ms(pause_, job.num_attempts);
        const AttemptEnd end = other_truth && !job.cancel_requested
                                   ? AttemptEnd{.attempt = AttemptState::Failed,
                                                .job = JobState::Queued,
                                                .failure = failure,
                                                .counts = false}
                                   : end_of_failed(job, failure, retry_at_ms);
        if (job.kind == JobKind::Intake && end.job == JobState::Failed)
            refuse_dive(session, job, failure);
        if (!partial.artifacts.empty() && end.job == JobState::Failed)
            keep_partial_result(session, lease, job, partial);
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

bool JobStore::return_to_queue(const Lease& lease, const Failure& failure) {
    return with_lease(lease, [&](soci::session& session, const Job& job) {
        const std::int64_t retry_at_ms = Catalog::now_ms(session) + pause_ms(pause_, lease.attempt);
        end_attempt(session, job, end_of_put_back(job, failure, retry_at_ms));
    });
}

int JobStore::requeue_expired() {
    bool found = false;  // read without the write lock, as in claim()
    catalog_.read([&](soci::session& session) { found = has_lost_jobs(session); });
    if (!found) return 0;

    int num_expired = 0;
    catalog_.transaction([&](soci::session& session) { num_expired = end_expired(session); });
    return num_expired;
}

}  // namespace divemesh::storage
