#include "storage/leftovers.hpp"

#include "storage/sql.hpp"

namespace divemesh::storage {
namespace {

struct EndedAttempt {
    std::string job_id;
    int number = 0;
};

struct EndedAttemptRow {
    EndedAttempt attempt;

    void define(soci::statement& statement) {
        define_columns(statement, attempt.job_id, attempt.number);
    }
    EndedAttempt value() const { return attempt; }
};

std::vector<EndedAttempt> ended_attempts(Catalog& catalog,
                                         std::chrono::milliseconds age,
                                         int limit) {
    std::vector<EndedAttempt> attempts;
    catalog.read([&](soci::session& session) {
        const std::int64_t before_ms = Catalog::now_ms(session) - age.count();
        attempts = select_all<EndedAttemptRow>(
            session,
            "SELECT job_id, number FROM attempts WHERE cleaned = 0"
            " AND state NOT IN ('running', 'succeeded') AND finished_at_ms <= :before"
            " ORDER BY finished_at_ms LIMIT :limit",
            soci::use(before_ms, "before"),
            soci::use(limit, "limit"));
    });
    return attempts;
}

// Keys of an attempt begin with jobs/ID/attempt-NUMBER-; the lease follows.
void remove_blobs(BlobStore& blobs, const EndedAttempt& attempt) {
    const std::string folder = "jobs/" + attempt.job_id + "/";
    const std::string name = "attempt-" + std::to_string(attempt.number) + "-";
    for (const std::string& child : blobs.children(folder))
        if (child.starts_with(name)) blobs.remove_prefix(folder + child + "/");
}

}  // namespace

int remove_leftovers(Catalog& catalog, BlobStore& blobs, std::chrono::milliseconds age, int limit) {
    const auto attempts = ended_attempts(catalog, age, limit);
    for (const EndedAttempt& attempt : attempts) {
        remove_blobs(blobs, attempt);
        catalog.transaction([&](soci::session& session) {
            execute(session,
                    "UPDATE attempts SET cleaned = 1 WHERE job_id = :job AND number = :number",
                    soci::use(attempt.job_id, "job"),
                    soci::use(attempt.number, "number"));
        });
    }
    return static_cast<int>(attempts.size());
}

void forget_events(Catalog& catalog, std::chrono::milliseconds age) {
    catalog.transaction([&](soci::session& session) {
        const std::int64_t before_ms = Catalog::now_ms(session) - age.count();
        execute(
            session, "DELETE FROM events WHERE time_ms < :before", soci::use(before_ms, "before"));
    });
}

}  // namespace divemesh::storage
