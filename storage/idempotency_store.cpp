#include "storage/idempotency_store.hpp"

#include "storage/sql.hpp"

namespace divemesh::storage {
namespace {

struct AnswerRow {
    StoredAnswer answer;

    void define(soci::statement& statement) {
        define_columns(statement, answer.fingerprint, answer.status, answer.headers, answer.body);
    }
    StoredAnswer value() const { return answer; }
};

}  // namespace

std::optional<StoredAnswer> IdempotencyStore::find(const std::string& token_id,
                                                   const std::string& key) {
    std::optional<StoredAnswer> answer;
    catalog_.read([&](soci::session& session) {
        answer = select_one<AnswerRow>(session,
                                       "SELECT fingerprint, status, headers, body"
                                       " FROM idempotent_answers"
                                       " WHERE token_id = :token AND key = :key",
                                       soci::use(token_id, "token"),
                                       soci::use(key, "key"));
    });
    return answer;
}

void IdempotencyStore::put(const std::string& token_id,
                           const std::string& key,
                           const StoredAnswer& answer) {
    catalog_.transaction([&](soci::session& session) {
        const std::int64_t now_ms = Catalog::now_ms(session);
        execute(session,
                "INSERT INTO idempotent_answers"
                " (token_id, key, fingerprint, status, headers, body, created_at_ms)"
                " VALUES (:token, :key, :fingerprint, :status, :headers, :body, :now)"
                " ON CONFLICT DO NOTHING",
                soci::use(token_id, "token"),
                soci::use(key, "key"),
                soci::use(answer.fingerprint, "fingerprint"),
                soci::use(answer.status, "status"),
                soci::use(answer.headers, "headers"),
                soci::use(answer.body, "body"),
                soci::use(now_ms, "now"));
    });
}

void IdempotencyStore::forget(std::int64_t older_than_ms) {
    catalog_.transaction([&](soci::session& session) {
        const std::int64_t before_ms = Catalog::now_ms(session) - older_than_ms;
        execute(session,
                "DELETE FROM idempotent_answers WHERE created_at_ms < :before",
                soci::use(before_ms, "before"));
        execute(session,
                "DELETE FROM requested_jobs WHERE created_at_ms < :before",
                soci::use(before_ms, "before"));
    });
}

}  // namespace divemesh::storage
