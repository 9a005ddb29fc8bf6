#include "storage/project_usage.hpp"

#include "schemas/error.hpp"
#include "storage/sql.hpp"

namespace divemesh::storage {
namespace {

struct UsageRow {
    ProjectUsage usage;

    void define(soci::statement& statement) {
        define_columns(statement, usage.num_dives, usage.stored_bytes);
    }
    ProjectUsage value() const { return usage; }
};

}  // namespace

// A final upload counts once it is complete. Until then its parts count, and the bytes it repeats
// of them.
ProjectUsage read_usage(soci::session& session, const std::string& project) {
    return select_one<UsageRow>(
               session,
               "SELECT (SELECT COUNT(*) FROM dives"
               "   WHERE (:project = '' OR project = :project) AND deleted_at_ms = 0),"
               " (SELECT COALESCE(SUM(archive_bytes), 0) FROM dives"
               "   WHERE (:project = '' OR project = :project))"
               " + (SELECT COALESCE(SUM(size_bytes), 0) FROM truth_files"
               "   WHERE (:project = '' OR project = :project))"
               " + (SELECT COALESCE(SUM(result_bytes), 0) FROM jobs"
               "   WHERE (:project = '' OR project = :project) AND result_bytes > 0)"
               " + (SELECT COALESCE(SUM(CASE"
               "     WHEN concat LIKE 'final;%' AND offset_bytes < length_bytes THEN repeated_bytes"
               "     ELSE COALESCE(length_bytes, offset_bytes) END), 0) FROM uploads"
               "   WHERE (:project = '' OR project = :project) AND dive_id IS NULL AND ended = '')",
               soci::use(project, "project"))
        .value_or(ProjectUsage{});
}

ProjectUsage read_usage(Catalog& catalog, const std::string& project) {
    ProjectUsage usage;
    catalog.read([&](soci::session& session) { usage = read_usage(session, project); });
    return usage;
}

void require_bytes_of_quota(soci::session& session,
                            const std::string& project,
                            std::int64_t more_bytes,
                            std::int64_t max_num_bytes) {
    if (max_num_bytes == 0) return;
    const std::int64_t stored = read_usage(session, project).stored_bytes;
    if (stored > max_num_bytes || more_bytes > max_num_bytes - stored)
        throw Error(ErrorCode::OutOfQuota,
                    "project " + project + " has " + std::to_string(stored) + " of " +
                        std::to_string(max_num_bytes) + " bytes, " + std::to_string(more_bytes) +
                        " more are too many: delete dives, results or uploads (the bytes of a "
                        "deleted dive or result count until it expires), or ask the "
                        "administrator");
}

void require_dive_of_quota(soci::session& session,
                           const std::string& project,
                           std::int64_t max_num_dives,
                           const std::string& remedy) {
    if (max_num_dives == 0 || read_usage(session, project).num_dives < max_num_dives) return;
    throw Error(ErrorCode::OutOfQuota,
                "project " + project + " has " + std::to_string(max_num_dives) +
                    " dives, which is its limit: " + remedy);
}

}  // namespace divemesh::storage
