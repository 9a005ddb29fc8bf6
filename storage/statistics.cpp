#include "storage/statistics.hpp"

#include "storage/sql.hpp"

namespace divemesh::storage {
namespace {

std::int64_t number(soci::session& session, const std::string& sql) {
    std::int64_t value = 0;
    session << sql, soci::into(value);
    return value;
}

Statistics::Counts counts(soci::session& session,
                          const std::string& what,
                          const std::string& from) {
    return select_all<CountRow>(
        session, "SELECT state, " + what + " FROM " + from + " GROUP BY state ORDER BY state");
}

}  // namespace

Statistics read_statistics(Catalog& catalog) {
    Statistics all;
    catalog.read([&](soci::session& session) {
        const std::int64_t now_ms = Catalog::now_ms(session);
        all.jobs = counts(session, "COUNT(*)", "jobs");
        all.dives = counts(session, "COUNT(*)", "dives");
        all.attempts = counts(session, "COUNT(*)", "attempts");
        all.attempt_ms = counts(
            session, "SUM(finished_at_ms - started_at_ms)", "attempts WHERE finished_at_ms > 0");
        all.stages = read_stage_seconds(session);
        const std::int64_t queued_at = number(
            session, "SELECT COALESCE(MIN(created_at_ms), 0) FROM jobs WHERE state = 'queued'");
        all.oldest_queued_ms = queued_at > 0 ? now_ms - queued_at : 0;
        const std::int64_t lease_ends = number(
            session,
            "SELECT COALESCE(MIN(lease_expires_at_ms), 0) FROM jobs WHERE state = 'running'");
        all.lease_overdue_ms = lease_ends > 0 ? now_ms - lease_ends : 0;
        const std::string open =
            " FROM uploads WHERE dive_id IS NULL AND ended = ''"
            " AND (length_bytes IS NULL OR offset_bytes < length_bytes)";
        all.uploads_open = number(session, "SELECT COUNT(*)" + open);
        all.uploads_open_bytes = number(session, "SELECT COALESCE(SUM(offset_bytes), 0)" + open);
        all.archive_bytes = number(session, "SELECT COALESCE(SUM(archive_bytes), 0) FROM dives");
        all.artifact_bytes = number(session, "SELECT COALESCE(SUM(size_bytes), 0) FROM artifacts");
        all.deliveries_waiting =
            number(session, "SELECT COUNT(*) FROM webhook_deliveries WHERE state = 'waiting'");
    });
    return all;
}

}  // namespace divemesh::storage
