#include "storage/token_store.hpp"

#include <algorithm>
#include <array>
#include <string_view>

#include "schemas/content_hash.hpp"
#include "schemas/error.hpp"
#include "storage/ids.hpp"
#include "storage/sql.hpp"

namespace divemesh::storage {
namespace {

constexpr std::array<std::string_view, 4> kScopes = {
    "dives:read", "dives:write", "jobs:write", "admin"};
constexpr std::int64_t kUseRecordedEveryMs = 60'000;

#define TOKEN_COLUMNS \
    "id, name, project, scopes, secret_sha256, created_at_ms, last_used_at_ms, revoked"

struct TokenRow {
    Token token;
    std::string scopes;
    int revoked = 0;

    void define(soci::statement& statement) {
        statement.exchange(soci::into(token.id));
        statement.exchange(soci::into(token.name));
        statement.exchange(soci::into(token.project));
        statement.exchange(soci::into(scopes));
        statement.exchange(soci::into(token.secret_sha256));
        statement.exchange(soci::into(token.created_at_ms));
        statement.exchange(soci::into(token.last_used_at_ms));
        statement.exchange(soci::into(revoked));
    }
    Token value() const {
        Token value = token;
        value.scopes = nlohmann::json::parse(scopes).get<std::vector<std::string>>();
        value.revoked = revoked != 0;
        return value;
    }
};

// Takes as long for the first character that differs as for the last.
bool equal_in_constant_time(std::string_view a, std::string_view b) {
    if (a.size() != b.size()) return false;
    unsigned difference = 0;
    for (std::size_t i = 0; i < a.size(); ++i)
        difference |= static_cast<unsigned>(a[i]) ^ static_cast<unsigned>(b[i]);
    return difference == 0;
}

void check_scopes(const std::vector<std::string>& scopes) {
    if (scopes.empty()) throw Error(ErrorCode::InvalidArgument, "a token needs a scope");
    for (const std::string& scope : scopes)
        if (std::find(kScopes.begin(), kScopes.end(), scope) == kScopes.end())
            throw Error(
                ErrorCode::InvalidArgument,
                "unknown scope: " + scope + " (known: dives:read, dives:write, jobs:write, admin)");
}

}  // namespace

CreatedToken TokenStore::create(const std::string& name,
                                const std::string& project,
                                const std::vector<std::string>& scopes) {
    check_scopes(scopes);
    CreatedToken created;
    created.secret = "dm_" + random_hex(32);
    created.token = {.id = new_id("token"),
                     .name = name,
                     .project = project,
                     .scopes = scopes,
                     .secret_sha256 = sha256_hex(created.secret)};
    const std::string scopes_text = to_text(scopes);
    catalog_.transaction([&](soci::session& session) {
        created.token.created_at_ms = Catalog::now_ms(session);
        execute(session,
                "INSERT INTO tokens (id, name, project, scopes, secret_sha256, created_at_ms)"
                " VALUES (:id, :name, :project, :scopes, :hash, :now)",
                soci::use(created.token.id, "id"),
                soci::use(name, "name"),
                soci::use(project, "project"),
                soci::use(scopes_text, "scopes"),
                soci::use(created.token.secret_sha256, "hash"),
                soci::use(created.token.created_at_ms, "now"));
    });
    return created;
}

std::optional<Token> TokenStore::find(const std::string& secret) {
    const std::string hash = sha256_hex(secret);
    std::optional<Token> token;
    std::int64_t now_ms = 0;
    catalog_.read([&](soci::session& session) {
        now_ms = Catalog::now_ms(session);
        token = select_one<TokenRow>(session,
                                     "SELECT " TOKEN_COLUMNS
                                     " FROM tokens WHERE secret_sha256 = :hash AND revoked = 0",
                                     soci::use(hash, "hash"));
    });
    if (!token || !equal_in_constant_time(token->secret_sha256, hash)) return std::nullopt;
    if (now_ms - token->last_used_at_ms >= kUseRecordedEveryMs) record_use(token->id, now_ms);
    return token;
}

// A full disk or a busy catalog must not keep anybody out who may come in.
void TokenStore::record_use(const std::string& id, std::int64_t now_ms) {
    try {
        catalog_.transaction([&](soci::session& session) {
            execute(session,
                    "UPDATE tokens SET last_used_at_ms = :now WHERE id = :id",
                    soci::use(now_ms, "now"),
                    soci::use(id, "id"));
        });
    } catch (const Error&) {
        return;
    }
}

std::vector<Token> TokenStore::list() {
    std::vector<Token> tokens;
    catalog_.read([&](soci::session& session) {
        tokens = select_all<TokenRow>(
            session, "SELECT " TOKEN_COLUMNS " FROM tokens ORDER BY created_at_ms, id");
    });
    return tokens;
}

void TokenStore::revoke(const std::string& id) {
    catalog_.transaction([&](soci::session& session) {
        if (execute(session, "UPDATE tokens SET revoked = 1 WHERE id = :id", soci::use(id, "id")) ==
            0)
            throw Error(ErrorCode::NotFound, "no token " + id);
    });
}

bool TokenStore::empty() {
    int usable = 0;
    catalog_.read([&](soci::session& session) {
        session << "SELECT COUNT(*) FROM tokens WHERE revoked = 0", soci::into(usable);
    });
    return usable == 0;
}

}  // namespace divemesh::storage
