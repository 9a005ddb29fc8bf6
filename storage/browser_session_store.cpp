#include "storage/browser_session_store.hpp"

#include "schemas/content_hash.hpp"
#include "schemas/error.hpp"
#include "storage/ids.hpp"
#include "storage/sql.hpp"
#include "storage/token_store.hpp"

namespace divemesh::storage {
namespace {

constexpr std::int64_t kUseRecordedEveryMs = 60'000;
constexpr std::size_t kSecretBytes = 32;

#define IS_OPEN "created_at_ms > :begun AND last_used_at_ms > :used"

std::int64_t milliseconds(std::chrono::milliseconds time) { return time.count(); }

struct SessionRow {
    std::string token_id;
    std::int64_t created_at_ms = 0;
    std::int64_t last_used_at_ms = 0;

    void define(soci::statement& statement) {
        define_columns(statement, token_id, created_at_ms, last_used_at_ms);
    }
    SessionRow value() const { return *this; }
};

// Returns when a session that began then ends at the latest.
std::int64_t end_of(std::int64_t created_at_ms, const Token& token) {
    const std::int64_t end = created_at_ms + milliseconds(kSessionLifetime);
    return token.expires_at_ms > 0 ? std::min(end, token.expires_at_ms) : end;
}

CreatedSession insert(soci::session& session, const Token& token, std::int64_t now_ms) {
    CreatedSession created{{token, end_of(now_ms, token)}, random_hex(kSecretBytes)};
    const std::string hash = sha256_hex(created.secret);
    execute(session,
            "INSERT INTO browser_sessions (secret_sha256, token_id, created_at_ms, last_used_at_ms)"
            " VALUES (:hash, :token, :now, :now)",
            soci::use(hash, "hash"),
            soci::use(token.id, "token"),
            soci::use(now_ms, "now"));
    execute(session,
            "DELETE FROM browser_sessions WHERE token_id = :token AND secret_sha256 NOT IN"
            " (SELECT secret_sha256 FROM browser_sessions WHERE token_id = :token"
            "  ORDER BY created_at_ms DESC, CASE WHEN secret_sha256 = :hash THEN 0 ELSE 1 END"
            "  LIMIT 100)",
            soci::use(token.id, "token"),
            soci::use(hash, "hash"));
    return created;
}

}  // namespace

CreatedSession BrowserSessionStore::create(const Token& token) {
    CreatedSession created;
    catalog_.transaction([&](soci::session& session) {
        created = insert(session, token, Catalog::now_ms(session));
    });
    return created;
}

std::optional<CreatedSession> BrowserSessionStore::redeem(const std::string& one_shot,
                                                          const std::string& path) {
    std::optional<CreatedSession> created;
    catalog_.transaction([&](soci::session& session) {
        const std::int64_t now_ms = Catalog::now_ms(session);
        const auto owner = take_one_shot(session, one_shot, path, "", now_ms);
        if (owner) created = insert(session, *owner, now_ms);
    });
    return created;
}

std::optional<BrowserSession> BrowserSessionStore::find(const std::string& secret) {
    const std::string hash = sha256_hex(secret);
    std::optional<SessionRow> row;
    std::optional<Token> token;
    std::int64_t now_ms = 0;
    catalog_.read([&](soci::session& session) {
        now_ms = Catalog::now_ms(session);
        const std::int64_t begun = now_ms - milliseconds(kSessionLifetime);
        const std::int64_t used = now_ms - milliseconds(kSessionIdle);
        row = select_one<SessionRow>(session,
                                     "SELECT token_id, created_at_ms, last_used_at_ms"
                                     " FROM browser_sessions"
                                     " WHERE secret_sha256 = :hash AND " IS_OPEN,
                                     soci::use(hash, "hash"),
                                     soci::use(begun, "begun"),
                                     soci::use(used, "used"));
        if (row) token = valid_token(session, row->token_id, now_ms);
    });
    if (!token) return std::nullopt;
    if (now_ms - row->last_used_at_ms >= kUseRecordedEveryMs) record_use(hash, token->id, now_ms);
    return BrowserSession{*token, end_of(row->created_at_ms, *token)};
}

// A full disk or a busy catalog must not sign a browser out.
void BrowserSessionStore::record_use(const std::string& hash,
                                     const std::string& token_id,
                                     std::int64_t now_ms) {
    try {
        catalog_.transaction([&](soci::session& session) {
            execute(
                session,
                "UPDATE browser_sessions SET last_used_at_ms = :now WHERE secret_sha256 = :hash",
                soci::use(now_ms, "now"),
                soci::use(hash, "hash"));
            execute(session,
                    "UPDATE tokens SET last_used_at_ms = :now WHERE id = :token",
                    soci::use(now_ms, "now"),
                    soci::use(token_id, "token"));
        });
    } catch (const Error&) {
        if (!catalog_.may_wait()) throw;
    }
}

void BrowserSessionStore::end(const std::string& secret) {
    const std::string hash = sha256_hex(secret);
    catalog_.transaction([&](soci::session& session) {
        execute(session,
                "DELETE FROM browser_sessions WHERE secret_sha256 = :hash",
                soci::use(hash, "hash"));
    });
}

void BrowserSessionStore::forget_ended() {
    catalog_.transaction([&](soci::session& session) {
        const std::int64_t now_ms = Catalog::now_ms(session);
        const std::int64_t begun = now_ms - milliseconds(kSessionLifetime);
        const std::int64_t used = now_ms - milliseconds(kSessionIdle);
        execute(session,
                "DELETE FROM browser_sessions WHERE NOT (" IS_OPEN
                ") OR token_id IN (SELECT id FROM tokens WHERE revoked = 1"
                " OR (expires_at_ms > 0 AND expires_at_ms <= :now))",
                soci::use(begun, "begun"),
                soci::use(used, "used"),
                soci::use(now_ms, "now"));
    });
}

}  // namespace divemesh::storage
