#include "storage/job_store.hpp"

#include "schemas/error.hpp"
#include "schemas/json.hpp"
#include "storage/dive_rows.hpp"
#include "storage/event_store.hpp"
#include "storage/job_changes.hpp"
#include "storage/job_rows.hpp"
#include "storage/page_cursor.hpp"
#include "storage/report_jobs.hpp"
#include "storage/result_removal.hpp"
#include "storage/sql.hpp"

namespace divemesh::storage {
namespace {

constexpr int kMaxMaxAttempts = 20;
constexpr std::size_t kMaxParents = 16;

struct ArtifactRow {
    Artifact artifact;

    void define(soci::statement& statement) {
        define_columns(statement,
                       artifact.job_id,
                       artifact.name,
                       artifact.media_type,
                       artifact.sha256,
                       artifact.size_bytes,
                       artifact.blob);
    }
    Artifact value() const { return artifact; }
};

void check(const NewJob& job) {
    if (job.kind == JobKind::Intake)
        throw Error(ErrorCode::InvalidArgument, "an intake job is created only with its dive");
    check_priority(job.priority);
    if (job.parents.size() > kMaxParents)
        throw Error(ErrorCode::InvalidArgument,
                    "a job can wait for at most " + std::to_string(kMaxParents) + " others");
    if (job.max_attempts < 1 || job.max_attempts > kMaxMaxAttempts)
        throw Error(ErrorCode::InvalidArgument,
                    "max_attempts is " + std::to_string(job.max_attempts) + ": give 1 to " +
                        std::to_string(kMaxMaxAttempts));
    if (!job.options.is_object())
        throw Error(ErrorCode::InvalidArgument, "the options of a job must be an object");
}

void check_parents(soci::session& session, const NewJob& request) {
    for (const std::string& id : request.parents) {
        const Job parent = read_job(session, id);
        if (parent.project != request.project) throw Error(ErrorCode::NotFound, "no job " + id);
        if (is_finished(parent.state) && parent.state != JobState::Succeeded)
            throw Error(ErrorCode::Conflict,
                        "job " + id + " is " + std::string(to_string(parent.state)) +
                            ", so no job can wait for it: retry it first");
    }
}

std::optional<Job> find_requested(soci::session& session, const std::string& request_key) {
    if (request_key.empty()) return std::nullopt;
    return select_one<JobRow>(
        session,
        "SELECT " + std::string(kJobColumns) +
            " FROM jobs WHERE id = (SELECT job_id FROM requested_jobs WHERE request_key = :key)",
        soci::use(request_key, "key"));
}

void keep_request(soci::session& session, const std::string& request_key, const Job& job) {
    if (request_key.empty()) return;
    const std::int64_t now_ms = Catalog::now_ms(session);
    execute(session,
            "INSERT INTO requested_jobs (request_key, job_id, created_at_ms)"
            " VALUES (:key, :job, :now)",
            soci::use(request_key, "key"),
            soci::use(job.id, "job"),
            soci::use(now_ms, "now"));
}

}  // namespace

EnqueuedJob enqueue_job(soci::session& session, const NewJob& request) {
    check(request);
    if (auto requested = find_requested(session, request.request_key))
        return {std::move(*requested), false};
    const Dive dive = read_dive(session, request.dive_id);
    require_usable(dive);
    NewJob owned = request;
    owned.project = dive.project;
    resolve_names(session, dive, owned);
    check_parents(session, owned);
    auto twin = find_twin(session, dive.id, unique_key(owned));
    const bool is_new = !twin;
    EnqueuedJob enqueued{twin ? std::move(*twin) : insert_job(session, owned), is_new};
    keep_request(session, request.request_key, enqueued.job);
    return enqueued;
}

EnqueuedJob JobStore::enqueue(const NewJob& request) {
    EnqueuedJob enqueued;
    catalog_.transaction([&](soci::session& session) { enqueued = enqueue_job(session, request); });
    return enqueued;
}

Job JobStore::get(const std::string& id) {
    Job job;
    catalog_.read([&](soci::session& session) { job = read_job(session, id); });
    return job;
}

Page<Job> JobStore::list(const JobFilter& filter, const PageRequest& page) {
    const PageStart start = page_start(page);
    const std::string state = filter.state ? std::string(to_string(*filter.state)) : "";
    const std::string kind = filter.kind ? std::string(to_string(*filter.kind)) : "";
    const int deleted = filter.deleted ? 1 : 0;
    std::vector<Job> rows;
    catalog_.read([&](soci::session& session) {
        rows = select_all<JobRow>(
            session,
            "SELECT " + std::string(kJobColumns) + " FROM jobs WHERE " + start.condition +
                " AND (:project = '' OR project = :project) AND (:dive = '' OR dive_id = :dive)"
                " AND (:state = '' OR state = :state) AND (:kind = '' OR kind = :kind)"
                " AND (deleted_at_ms > 0) = (:deleted = 1)"
                " AND created_at_ms > :after AND created_at_ms < :before"
                " ORDER BY " +
                start.order + " LIMIT :limit",
            soci::use(start.created_at_ms, "age"),
            soci::use(start.id, "id"),
            soci::use(filter.project, "project"),
            soci::use(filter.dive_id, "dive"),
            soci::use(state, "state"),
            soci::use(kind, "kind"),
            soci::use(deleted, "deleted"),
            soci::use(filter.created_after_ms, "after"),
            soci::use(filter.created_before_ms, "before"),
            soci::use(start.limit_plus_one, "limit"));
    });
    return make_page(std::move(rows), page);
}

std::vector<Attempt> JobStore::attempts(const std::string& job_id) {
    std::vector<Attempt> attempts;
    catalog_.read([&](soci::session& session) {
        read_job(session, job_id);
        attempts = select_all<AttemptRow>(session,
                                          "SELECT " + std::string(kAttemptColumns) +
                                              " FROM attempts WHERE job_id = :job ORDER BY number",
                                          soci::use(job_id, "job"));
    });
    return attempts;
}

std::vector<Artifact> JobStore::artifacts(const std::string& job_id) {
    std::vector<Artifact> artifacts;
    catalog_.read([&](soci::session& session) {
        require_result(session, job_id);
        artifacts = select_all<ArtifactRow>(
            session,
            "SELECT job_id, name, media_type, sha256, size_bytes, blob FROM artifacts"
            " WHERE job_id = :job ORDER BY name",
            soci::use(job_id, "job"));
    });
    return artifacts;
}

Artifact JobStore::artifact(const std::string& job_id, const std::string& name) {
    std::optional<Artifact> artifact;
    catalog_.read([&](soci::session& session) {
        require_result(session, job_id);
        artifact = select_one<ArtifactRow>(
            session,
            "SELECT job_id, name, media_type, sha256, size_bytes, blob FROM artifacts"
            " WHERE job_id = :job AND name = :name",
            soci::use(job_id, "job"),
            soci::use(name, "name"));
    });
    if (!artifact) throw Error(ErrorCode::NotFound, "job " + job_id + " has no such artifact");
    return std::move(*artifact);
}

std::string JobStore::log(const std::string& job_id) {
    std::string log;
    catalog_.read([&](soci::session& session) {
        read_job(session, job_id);
        log = select_one<TextRow>(
                  session,
                  "SELECT log FROM attempts WHERE job_id = :job ORDER BY number DESC LIMIT 1",
                  soci::use(job_id, "job"))
                  .value_or("");
    });
    return log;
}

std::string JobStore::log(const std::string& job_id, int attempt) {
    std::optional<std::string> log;
    catalog_.read([&](soci::session& session) {
        log =
            select_one<TextRow>(session,
                                "SELECT log FROM attempts WHERE job_id = :job AND number = :number",
                                soci::use(job_id, "job"),
                                soci::use(attempt, "number"));
    });
    if (!log)
        throw Error(ErrorCode::NotFound,
                    "job " + job_id + " has no attempt " + std::to_string(attempt));
    return std::move(*log);
}

std::vector<std::pair<JobState, std::int64_t>> JobStore::count_by_state() {
    std::vector<std::pair<JobState, std::int64_t>> counts;
    catalog_.read([&](soci::session& session) {
        counts.clear();
        for (const auto& [state, count] : select_all<CountRow>(
                 session, "SELECT state, COUNT(*) FROM jobs GROUP BY state ORDER BY state"))
            counts.emplace_back(job_state_from_string(state), count);
    });
    return counts;
}

}  // namespace divemesh::storage
