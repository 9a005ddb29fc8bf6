#include "storage/result_removal.hpp"

#include <algorithm>
#include <set>

#include "schemas/error.hpp"
#include "storage/job_changes.hpp"
#include "storage/job_rows.hpp"
#include "storage/sql.hpp"

namespace divemesh::storage {
namespace {

struct DeletionRow {
    Deletion deletion;

    void define(soci::statement& statement) {
        define_columns(statement, deletion.deleted_at_ms, deletion.expires_at_ms);
    }
    Deletion value() const { return deletion; }
};

// Jobs that wait for the job `jobs.id`, or read its result.
const std::string kReaders =
    "(SELECT 1 FROM job_parents JOIN jobs AS readers ON readers.id = job_parents.job_id"
    " WHERE job_parents.parent_id = jobs.id AND readers.state IN ('held', 'queued', 'running'))";

Deletion read_deletion(soci::session& session, const std::string& job_id) {
    const auto deletion =
        select_one<DeletionRow>(session,
                                "SELECT deleted_at_ms, expires_at_ms FROM jobs WHERE id = :id",
                                soci::use(job_id, "id"));
    if (!deletion) throw Error(ErrorCode::NotFound, "no job " + job_id);
    return *deletion;
}

void write_deletion(soci::session& session, const std::string& job_id, const Deletion& deletion) {
    execute(session,
            "UPDATE jobs SET deleted_at_ms = :deleted, expires_at_ms = :expires WHERE id = :id",
            soci::use(deletion.deleted_at_ms, "deleted"),
            soci::use(deletion.expires_at_ms, "expires"),
            soci::use(job_id, "id"));
}

void require_removable(soci::session& session, const Job& job) {
    if (job.kind == JobKind::Intake)
        throw Error(ErrorCode::Conflict,
                    "job " + job.id + " is the intake of a dive: delete dive " + job.dive_id);
    if (!is_finished(job.state))
        throw Error(ErrorCode::Conflict,
                    "job " + job.id + " is " + std::string(to_string(job.state)) +
                        ": cancel it, then delete it");
    if (select_one<TextRow>(session,
                            "SELECT id FROM jobs WHERE id = :id AND EXISTS " + kReaders,
                            soci::use(job.id, "id")))
        throw Error(ErrorCode::Conflict,
                    "another job still reads the result of job " + job.id +
                        ": cancel that one, or wait until it has ended");
}

}  // namespace

void require_result(soci::session& session, const std::string& job_id) {
    if (read_deletion(session, job_id).deleted_at_ms > 0)
        throw Error(ErrorCode::Gone,
                    "the result of job " + job_id +
                        " was deleted: restore it, as long as it has not expired");
}

Deletion ResultRemoval::deletion_of(const std::string& job_id) {
    Deletion deletion;
    catalog_.read([&](soci::session& session) { deletion = read_deletion(session, job_id); });
    return deletion;
}

void ResultRemoval::remove(const std::string& job_id, std::chrono::milliseconds keep) {
    catalog_.transaction([&](soci::session& session) {
        require_removable(session, read_job(session, job_id));
        Deletion deletion = read_deletion(session, job_id);
        const std::int64_t now_ms = Catalog::now_ms(session);
        const bool is_new = deletion.deleted_at_ms == 0;
        const std::int64_t expires_at_ms = now_ms + keep.count();
        deletion.expires_at_ms =
            is_new ? expires_at_ms : std::min(deletion.expires_at_ms, expires_at_ms);
        if (is_new) deletion.deleted_at_ms = now_ms;
        write_deletion(session, job_id, deletion);
        if (is_new) append_job_event(session, job_id, "job.deleted");
    });
}

void ResultRemoval::restore(const std::string& job_id) {
    catalog_.transaction([&](soci::session& session) {
        const Deletion deletion = read_deletion(session, job_id);
        if (deletion.deleted_at_ms == 0) return;
        if (deletion.expires_at_ms <= Catalog::now_ms(session))
            throw Error(ErrorCode::Conflict,
                        "the result of job " + job_id +
                            " has expired and cannot be restored: create a new job");
        write_deletion(session, job_id, {});
        execute(session, "UPDATE jobs SET kept = 1 WHERE id = :id", soci::use(job_id, "id"));
        append_job_event(session, job_id, "job.restored");
    });
}

int ResultRemoval::remove_old(
    std::chrono::milliseconds keep,
    int limit,
    const std::function<void(soci::session&, const std::string& job_id)>& deleted) {
    int num_removed = 0;
    catalog_.transaction([&](soci::session& session) {
        if (!select_one<TextRow>(session, "SELECT project FROM queues WHERE keep_results > 0"))
            return;
        const std::int64_t now_ms = Catalog::now_ms(session);
        const Deletion deletion{now_ms, now_ms + keep.count()};
        const auto old = select_all<TextRow>(
            session,
            "SELECT id FROM (SELECT id, kept, ROW_NUMBER() OVER"
            "    (PARTITION BY dive_id, kind ORDER BY finished_at_ms DESC, id DESC) AS place,"
            "    COALESCE(NULLIF((SELECT keep_results FROM queues WHERE queues.project ="
            "      jobs.project), 0), (SELECT keep_results FROM queues WHERE project = ''), 0)"
            "    AS num_kept, EXISTS " +
                kReaders +
                " AS is_read FROM jobs"
                "  WHERE state = 'succeeded' AND kind <> 'intake' AND deleted_at_ms = 0)"
                " AS ranked WHERE num_kept > 0 AND place > num_kept AND NOT is_read AND kept = 0"
                " ORDER BY id LIMIT :limit",
            soci::use(limit, "limit"));
        for (const std::string& job_id : old) {
            write_deletion(session, job_id, deletion);
            append_job_event(session, job_id, "job.deleted");
            deleted(session, job_id);
        }
        num_removed = static_cast<int>(old.size());
    });
    return num_removed;
}

std::vector<std::string> ResultRemoval::expired(int limit) {
    std::vector<std::string> ids;
    catalog_.read([&](soci::session& session) {
        const std::int64_t now_ms = Catalog::now_ms(session);
        ids = select_all<TextRow>(
            session,
            "SELECT id FROM jobs WHERE deleted_at_ms > 0 AND expires_at_ms <= :now"
            " AND EXISTS (SELECT 1 FROM artifacts WHERE job_id = jobs.id) AND NOT EXISTS " +
                kReaders + " ORDER BY expires_at_ms LIMIT :limit",
            soci::use(now_ms, "now"),
            soci::use(limit, "limit"));
    });
    return ids;
}

// Keys of an attempt begin with jobs/ID/attempt-NUMBER-LEASE/.
std::vector<std::string> ResultRemoval::blob_prefixes(const std::string& job_id) {
    std::vector<std::string> blobs;
    catalog_.read([&](soci::session& session) {
        blobs = select_all<TextRow>(session,
                                    "SELECT blob FROM artifacts WHERE job_id = :id ORDER BY blob",
                                    soci::use(job_id, "id"));
    });
    const std::string folder = "jobs/" + job_id + "/";
    std::set<std::string> prefixes;
    for (const std::string& blob : blobs)
        if (blob.starts_with(folder))
            prefixes.insert(blob.substr(0, blob.find('/', folder.size()) + 1));
    return {prefixes.begin(), prefixes.end()};
}

void ResultRemoval::forget(const std::string& job_id) {
    catalog_.transaction([&](soci::session& session) {
        execute(session,
                "DELETE FROM artifacts WHERE job_id = :id"
                " AND EXISTS (SELECT 1 FROM jobs WHERE id = :id AND deleted_at_ms > 0)",
                soci::use(job_id, "id"));
    });
}

}  // namespace divemesh::storage
