#include "storage/share_store.hpp"

#include "schemas/content_hash.hpp"
#include "schemas/error.hpp"
#include "storage/ids.hpp"
#include "storage/job_rows.hpp"
#include "storage/sql.hpp"

namespace divemesh::storage {
namespace {

constexpr std::size_t kMaxNameBytes = 100;
constexpr std::chrono::hours kMaxLifetime{24 * 366};
constexpr std::int64_t kMaxValidPerJob = 100;
constexpr std::size_t kSecretBytes = 16;

struct ShareRow {
    Share share;
    int revoked = 0;

    void define(soci::statement& statement) {
        define_columns(statement,
                       share.id,
                       share.job_id,
                       share.name,
                       share.created_at_ms,
                       share.last_used_at_ms,
                       share.expires_at_ms,
                       revoked);
    }
    Share value() const {
        Share value = share;
        value.withdrawn = revoked != 0;
        return value;
    }
};

void check(const NewShare& wanted) {
    if (wanted.name.size() > kMaxNameBytes)
        throw Error(ErrorCode::InvalidArgument, "\"name\" is longer than 100 bytes");
    if (wanted.lifetime.count() <= 0 || wanted.lifetime > kMaxLifetime)
        throw Error(ErrorCode::InvalidArgument,
                    "\"expires_in_s\" must be 1 to 31622400: a link is valid for a year at most");
}

void require_result(soci::session& session, const std::string& job_id) {
    const auto artifact = select_one<NumberRow>(
        session,
        "SELECT 1 FROM artifacts JOIN jobs ON jobs.id = job_id JOIN dives ON dives.id = dive_id"
        " WHERE job_id = :id AND jobs.deleted_at_ms = 0 AND dives.deleted_at_ms = 0 LIMIT 1",
        soci::use(job_id, "id"));
    if (!artifact)
        throw Error(ErrorCode::Conflict,
                    "job " + job_id +
                        " has no result to share: wait until it has succeeded, or "
                        "restore what was deleted");
}

void require_room(soci::session& session, const std::string& job_id, std::int64_t now_ms) {
    const auto num_valid = select_one<NumberRow>(session,
                                                 "SELECT COUNT(*) FROM tokens WHERE shared_job = "
                                                 ":id AND revoked = 0 AND expires_at_ms > :now",
                                                 soci::use(job_id, "id"),
                                                 soci::use(now_ms, "now"));
    if (num_valid.value_or(0) >= kMaxValidPerJob)
        throw Error(ErrorCode::Conflict,
                    "job " + job_id + " has " + std::to_string(kMaxValidPerJob) +
                        " links that are valid: withdraw one first");
}

}  // namespace

CreatedShare ShareStore::create(const std::string& job_id, const NewShare& wanted) {
    check(wanted);
    CreatedShare created;
    created.secret = "dms_" + random_hex(kSecretBytes);
    const std::string hash = sha256_hex(created.secret);
    Share& share = created.share;
    share = {.id = new_id("share"), .job_id = job_id, .name = wanted.name};
    catalog_.transaction([&](soci::session& session) {
        const Job job = read_job(session, job_id);
        require_result(session, job_id);
        share.created_at_ms = Catalog::now_ms(session);
        share.expires_at_ms = share.created_at_ms + wanted.lifetime.count() * 1000;
        require_room(session, job_id, share.created_at_ms);
        execute(session,
                "INSERT INTO tokens (id, name, project, scopes, shared_job, secret_sha256,"
                " created_at_ms, expires_at_ms)"
                " VALUES (:id, :name, :project, '[\"dives:read\"]', :job, :hash, :now, :expires)",
                soci::use(share.id, "id"),
                soci::use(share.name, "name"),
                soci::use(job.project, "project"),
                soci::use(job_id, "job"),
                soci::use(hash, "hash"),
                soci::use(share.created_at_ms, "now"),
                soci::use(share.expires_at_ms, "expires"));
    });
    return created;
}

std::vector<Share> ShareStore::list(const std::string& job_id) {
    std::vector<Share> shares;
    catalog_.read([&](soci::session& session) {
        shares = select_all<ShareRow>(
            session,
            "SELECT id, shared_job, name, created_at_ms, last_used_at_ms, expires_at_ms, revoked"
            " FROM tokens WHERE shared_job = :id AND shared_job <> ''"
            " ORDER BY created_at_ms, id",
            soci::use(job_id, "id"));
    });
    return shares;
}

void ShareStore::withdraw(const std::string& job_id, const std::string& share_id) {
    catalog_.transaction([&](soci::session& session) {
        if (execute(session,
                    "UPDATE tokens SET revoked = 1 WHERE id = :id AND shared_job = :job"
                    " AND shared_job <> ''",
                    soci::use(share_id, "id"),
                    soci::use(job_id, "job")) == 0)
            throw Error(ErrorCode::NotFound, "no share " + share_id + " of job " + job_id);
    });
}

}  // namespace divemesh::storage
