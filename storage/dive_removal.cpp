#include "storage/dive_removal.hpp"

#include "schemas/error.hpp"
#include "storage/dive_rows.hpp"
#include "storage/job_changes.hpp"
#include "storage/project_usage.hpp"
#include "storage/sql.hpp"

namespace divemesh::storage {
namespace {

std::vector<std::string> jobs_of(soci::session& session,
                                 const std::string& dive_id,
                                 const std::string& states) {
    return select_all<TextRow>(session,
                               "SELECT id FROM jobs WHERE dive_id = :dive AND state IN (" + states +
                                   ") ORDER BY created_at_ms, id",
                               soci::use(dive_id, "dive"));
}

void cancel_jobs(soci::session& session, const std::string& dive_id) {
    const Failure why{ErrorCode::Cancelled, "the dive was deleted"};
    for (const std::string& id : jobs_of(session, dive_id, "'held', 'queued'")) {
        // Cancelling one job may have cancelled those behind it.
        const auto waits = select_one<TextRow>(
            session,
            "SELECT id FROM jobs WHERE id = :id AND state IN ('held', 'queued')",
            soci::use(id, "id"));
        if (waits) change_state(session, id, JobState::Cancelled, why);
    }
    for (const std::string& id : jobs_of(session, dive_id, "'running'")) {
        execute(
            session, "UPDATE jobs SET cancel_requested = 1 WHERE id = :id", soci::use(id, "id"));
        append_job_event(session, id, "job.state");
    }
}

void write_times(soci::session& session, const Dive& dive) {
    execute(session,
            "UPDATE dives SET deleted_at_ms = :deleted, expires_at_ms = :expires WHERE id = :id",
            soci::use(dive.deleted_at_ms, "deleted"),
            soci::use(dive.expires_at_ms, "expires"),
            soci::use(dive.id, "id"));
}

}  // namespace

Dive DiveRemoval::remove(const std::string& id,
                         std::chrono::milliseconds keep,
                         const std::function<void(const Dive&)>& check) {
    Dive dive;
    catalog_.transaction([&](soci::session& session) {
        dive = read_dive(session, id);
        check(dive);
        const std::int64_t now_ms = Catalog::now_ms(session);
        if (dive.deleted_at_ms > 0) {
            dive.expires_at_ms = std::min(dive.expires_at_ms, now_ms + keep.count());
            return write_times(session, dive);
        }
        dive.deleted_at_ms = now_ms;
        dive.expires_at_ms = now_ms + keep.count();
        write_times(session, dive);
        cancel_jobs(session, id);
        append_dive_event(session, dive, "dive.deleted");
    });
    return dive;
}

Dive DiveRemoval::restore(const std::string& id, std::int64_t max_dives_of_project) {
    Dive dive;
    catalog_.transaction([&](soci::session& session) {
        dive = read_dive(session, id);
        if (dive.deleted_at_ms == 0) return;
        if (dive.expires_at_ms <= Catalog::now_ms(session))
            throw Error(ErrorCode::Conflict,
                        "dive " + id + " has expired and cannot be restored: upload it again");
        const auto again =
            find_recording(session, dive.project, dive.archive_sha256, dive.content_sha256);
        if (again && dive.state != DiveState::Refused)
            throw Error(ErrorCode::Conflict,
                        "the recording was uploaded again in the meantime: use dive " + again->id);
        require_dive_of_quota(
            session, dive.project, max_dives_of_project, "delete one, then restore this one");
        dive.deleted_at_ms = 0;
        dive.expires_at_ms = 0;
        write_times(session, dive);
        append_dive_event(session, dive, "dive.restored");
    });
    return dive;
}

std::vector<Dive> DiveRemoval::expired(int limit) {
    std::vector<Dive> dives;
    catalog_.read([&](soci::session& session) {
        const std::int64_t now_ms = Catalog::now_ms(session);
        dives = select_all<DiveRow>(
            session,
            "SELECT " + std::string(kDiveColumns) +
                " FROM dives WHERE deleted_at_ms > 0 AND expires_at_ms <= :now AND NOT EXISTS"
                " (SELECT 1 FROM jobs WHERE jobs.dive_id = dives.id AND jobs.state = 'running')"
                " AND NOT EXISTS (SELECT 1 FROM jobs AS parents"
                "   JOIN job_parents ON parent_id = parents.id"
                "   JOIN jobs AS readers ON readers.id = job_parents.job_id"
                "   WHERE parents.dive_id = dives.id AND readers.state = 'running')"
                " ORDER BY expires_at_ms LIMIT :limit",
            soci::use(now_ms, "now"),
            soci::use(limit, "limit"));
    });
    return dives;
}

std::vector<std::string> DiveRemoval::blob_prefixes(const Dive& dive) {
    std::vector<std::string> prefixes = {dive.blob.substr(0, dive.blob.rfind('/') + 1)};
    catalog_.read([&](soci::session& session) {
        for (const std::string& job : select_all<TextRow>(
                 session, "SELECT id FROM jobs WHERE dive_id = :id", soci::use(dive.id, "id")))
            prefixes.push_back("jobs/" + job + "/");
        for (const std::string& blob :
             select_all<TextRow>(session,
                                 "SELECT blob FROM truth_files WHERE dive_id = :id",
                                 soci::use(dive.id, "id")))
            prefixes.push_back(blob.substr(0, blob.rfind('/') + 1));
    });
    return prefixes;
}

bool DiveRemoval::forget(const std::string& id) {
    bool forgotten = false;
    catalog_.transaction([&](soci::session& session) {
        const Dive dive = read_dive(session, id);
        if (!jobs_of(session, id, "'running'").empty()) return;
        const std::string jobs = "(SELECT id FROM jobs WHERE dive_id = :id)";
        const std::string sets = "(SELECT number FROM metric_sets WHERE dive_id = :id)";
        const std::string names = "(SELECT number FROM metric_names)";  // lets the index be used
        const std::string statements[] = {
            "DELETE FROM artifacts WHERE job_id IN " + jobs,
            "DELETE FROM attempts WHERE job_id IN " + jobs,
            "DELETE FROM metric_values WHERE set_number IN " + sets + " AND metric IN " + names,
            "DELETE FROM metric_sets WHERE dive_id = :id",
            "DELETE FROM truth_files WHERE dive_id = :id",
            "DELETE FROM job_parents WHERE job_id IN " + jobs + " OR parent_id IN " + jobs,
            "DELETE FROM jobs WHERE dive_id = :id",
            "DELETE FROM uploads WHERE dive_id = :id",
            "DELETE FROM dive_tags WHERE dive_id = :id",
            "DELETE FROM dives WHERE id = :id"};
        for (const std::string& statement : statements)
            execute(session, statement, soci::use(id, "id"));
        append_dive_event(session, dive, "dive.removed");
        forgotten = true;
    });
    return forgotten;
}

}  // namespace divemesh::storage
