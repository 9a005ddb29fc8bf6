#include "storage/token_store.hpp"

#include <algorithm>
#include <string_view>

#include "schemas/content_hash.hpp"
#include "schemas/error.hpp"
#include "storage/ids.hpp"
#include "storage/sql.hpp"

namespace divemesh::storage {
namespace {

constexpr std::int64_t kUseRecordedEveryMs = 60'000;
constexpr std::size_t kMaxNameBytes = 100;
constexpr std::size_t kMaxPathBytes = 2048;
constexpr std::chrono::hours kMaxLifetime{24 * 3660};

#define TOKEN_COLUMNS                                                                      \
    "id, name, project, scopes, sensor, shared_job,"                                       \
    " COALESCE((SELECT dive_id FROM jobs WHERE jobs.id = shared_job), ''), secret_sha256," \
    " created_at_ms, last_used_at_ms, expires_at_ms, revoked"
// A sharing link is valid as long as nobody has deleted what it opens.
#define IS_VALID                                                                           \
    "revoked = 0 AND (expires_at_ms = 0 OR expires_at_ms > :now) AND (shared_job = '' OR " \
    "EXISTS (SELECT 1 FROM jobs JOIN dives ON dives.id = jobs.dive_id WHERE jobs.id = "    \
    "shared_job AND jobs.deleted_at_ms = 0 AND dives.deleted_at_ms = 0))"

#define IS_FOR_TARGET "secret_sha256 = :hash AND path IN (:path, :whole) AND expires_at_ms > :now"

bool is_known(const std::string& scope) {
    return std::find(kScopes.begin(), kScopes.end(), scope) != kScopes.end();
}

// The catalog may name scopes that no longer exist; they are left out.
struct TokenRow {
    Token token;
    std::string scopes;
    int revoked = 0;

    void define(soci::statement& statement) {
        define_columns(statement,
                       token.id,
                       token.name,
                       token.project,
                       scopes,
                       token.sensor,
                       token.shared_job,
                       token.shared_dive,
                       token.secret_sha256,
                       token.created_at_ms,
                       token.last_used_at_ms,
                       token.expires_at_ms,
                       revoked);
    }
    Token value() const {
        Token value = token;
        const auto stored = nlohmann::json::parse(scopes).get<std::vector<std::string>>();
        for (const std::string& scope : stored)
            if (is_known(scope)) value.scopes.push_back(scope);
        value.revoked = revoked != 0;
        return value;
    }
};

// Takes the same time wherever the first difference is.
bool equal_in_constant_time(std::string_view a, std::string_view b) {
    if (a.size() != b.size()) return false;
    unsigned difference = 0;
    for (std::size_t i = 0; i < a.size(); ++i)
        difference |= static_cast<unsigned>(a[i]) ^ static_cast<unsigned>(b[i]);
    return difference == 0;
}

void check_word(const std::string& what, const std::string& text) {
    if (!is_plain_word(text))
        throw Error(ErrorCode::InvalidArgument,
                    "\"" + what + "\" must be a-z 0-9 _ -, beginning with a letter or digit");
}

std::string known_scopes() {
    std::string known;
    for (const auto scope : kScopes) known += (known.empty() ? "" : ", ") + std::string(scope);
    return known;
}

void check_scopes(const std::vector<std::string>& scopes) {
    if (scopes.empty()) throw Error(ErrorCode::InvalidArgument, "a token needs at least one scope");
    for (const std::string& scope : scopes)
        if (!is_known(scope))
            throw Error(ErrorCode::InvalidArgument,
                        "unknown scope: " + scope + " (known: " + known_scopes() + ")");
}

void check(const NewToken& wanted) {
    if (wanted.name.empty() || wanted.name.size() > kMaxNameBytes)
        throw Error(ErrorCode::InvalidArgument, "\"name\" must be 1 to 100 bytes long");
    check_word("project", wanted.project);
    check_scopes(wanted.scopes);
    if (!wanted.sensor.empty()) check_word("sensor", wanted.sensor);
    const auto pushes = std::count(wanted.scopes.begin(), wanted.scopes.end(), "sensor:push");
    if ((pushes > 0) == wanted.sensor.empty())
        throw Error(ErrorCode::InvalidArgument,
                    "\"sensor\" is required for the scope sensor:push and not allowed for others");
    if (pushes > 0 && wanted.scopes.size() > 1)
        throw Error(ErrorCode::InvalidArgument,
                    "sensor:push must be the only scope of a token: create another token for the "
                    "other scopes");
    if (wanted.lifetime.count() < 0 || wanted.lifetime > kMaxLifetime)
        throw Error(ErrorCode::InvalidArgument, "a token can be valid for at most ten years");
}

std::int64_t milliseconds(std::chrono::seconds time) { return time.count() * 1000; }

}  // namespace

std::optional<Token> valid_token(soci::session& session,
                                 const std::string& id,
                                 std::int64_t now_ms) {
    return select_one<TokenRow>(session,
                                "SELECT " TOKEN_COLUMNS " FROM tokens WHERE id = :id AND " IS_VALID,
                                soci::use(id, "id"),
                                soci::use(now_ms, "now"));
}

std::optional<Token> take_one_shot(soci::session& session,
                                   const std::string& secret,
                                   const std::string& path,
                                   const std::string& query,
                                   std::int64_t now_ms) {
    const std::string hash = sha256_hex(secret);
    const std::string whole = path + "?" + query;
    const auto owner = select_one<TextRow>(session,
                                           "DELETE FROM one_shot_tokens WHERE " IS_FOR_TARGET
                                           " RETURNING token_id",
                                           soci::use(hash, "hash"),
                                           soci::use(path, "path"),
                                           soci::use(whole, "whole"),
                                           soci::use(now_ms, "now"));
    return owner ? valid_token(session, *owner, now_ms) : std::nullopt;
}

CreatedToken TokenStore::create(const NewToken& wanted) {
    check(wanted);
    CreatedToken created;
    created.secret = "dm_" + random_hex(32);
    created.token = {.id = new_id("token"),
                     .name = wanted.name,
                     .project = wanted.project,
                     .scopes = wanted.scopes,
                     .sensor = wanted.sensor,
                     .secret_sha256 = sha256_hex(created.secret)};
    Token& token = created.token;
    const std::string scopes = to_text(wanted.scopes);
    catalog_.transaction([&](soci::session& session) {
        token.created_at_ms = Catalog::now_ms(session);
        if (wanted.lifetime.count() > 0)
            token.expires_at_ms = token.created_at_ms + milliseconds(wanted.lifetime);
        execute(session,
                "INSERT INTO tokens (id, name, project, scopes, sensor, secret_sha256,"
                " created_at_ms, expires_at_ms)"
                " VALUES (:id, :name, :project, :scopes, :sensor, :hash, :now, :expires)",
                soci::use(token.id, "id"),
                soci::use(token.name, "name"),
                soci::use(token.project, "project"),
                soci::use(scopes, "scopes"),
                soci::use(token.sensor, "sensor"),
                soci::use(token.secret_sha256, "hash"),
                soci::use(token.created_at_ms, "now"),
                soci::use(token.expires_at_ms, "expires"));
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
                                     " FROM tokens WHERE secret_sha256 = :hash AND " IS_VALID,
                                     soci::use(hash, "hash"),
                                     soci::use(now_ms, "now"));
    });
    if (!token || !equal_in_constant_time(token->secret_sha256, hash)) return std::nullopt;
    if (now_ms - token->last_used_at_ms >= kUseRecordedEveryMs) record_use(token->id, now_ms);
    return token;
}

bool TokenStore::is_valid(const std::string& id) {
    bool valid = false;
    catalog_.read([&](soci::session& session) {
        const std::int64_t now_ms = Catalog::now_ms(session);
        valid = select_one<TextRow>(session,
                                    "SELECT id FROM tokens WHERE id = :id AND " IS_VALID,
                                    soci::use(id, "id"),
                                    soci::use(now_ms, "now"))
                    .has_value();
    });
    return valid;
}

std::optional<Token> TokenStore::get_valid(const std::string& id) {
    std::optional<Token> token;
    catalog_.read([&](soci::session& session) {
        const std::int64_t now_ms = Catalog::now_ms(session);
        token = select_one<TokenRow>(session,
                                     "SELECT " TOKEN_COLUMNS
                                     " FROM tokens WHERE id = :id AND " IS_VALID,
                                     soci::use(id, "id"),
                                     soci::use(now_ms, "now"));
    });
    return token;
}

// A full disk or a busy catalog must not lock a valid token out.
void TokenStore::record_use(const std::string& id, std::int64_t now_ms) {
    try {
        catalog_.transaction([&](soci::session& session) {
            execute(session,
                    "UPDATE tokens SET last_used_at_ms = :now WHERE id = :id",
                    soci::use(now_ms, "now"),
                    soci::use(id, "id"));
        });
    } catch (const Error&) {
        if (!catalog_.may_wait()) throw;
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
        const std::int64_t now_ms = Catalog::now_ms(session);
        session << "SELECT COUNT(*) FROM tokens WHERE shared_job = '' AND " IS_VALID,
            soci::use(now_ms, "now"), soci::into(usable);
    });
    return usable == 0;
}

OneShotToken TokenStore::create_one_shot(const Token& owner,
                                         const std::string& path,
                                         std::chrono::seconds lifetime) {
    if (path.size() > kMaxPathBytes)
        throw Error(ErrorCode::InvalidArgument, "\"path\" is longer than 2048 bytes");
    OneShotToken made{std::string(kOneShotPrefix) + random_hex(32), path};
    const std::string hash = sha256_hex(made.secret);
    catalog_.transaction([&](soci::session& session) {
        const std::int64_t now_ms = Catalog::now_ms(session);
        made.expires_at_ms = now_ms + milliseconds(lifetime);
        execute(session,
                "DELETE FROM one_shot_tokens WHERE expires_at_ms <= :now",
                soci::use(now_ms, "now"));
        if (owner.id.empty()) return;
        execute(session,
                "INSERT INTO one_shot_tokens (secret_sha256, token_id, path, expires_at_ms)"
                " VALUES (:hash, :token, :path, :expires)",
                soci::use(hash, "hash"),
                soci::use(owner.id, "token"),
                soci::use(path, "path"),
                soci::use(made.expires_at_ms, "expires"));
    });
    return made;
}

std::optional<Token> TokenStore::find_one_shot(const std::string& secret,
                                               const std::string& path,
                                               const std::string& query) {
    const std::string hash = sha256_hex(secret);
    const std::string whole = path + "?" + query;
    std::optional<Token> token;
    catalog_.read([&](soci::session& session) {
        const std::int64_t now_ms = Catalog::now_ms(session);
        const auto owner =
            select_one<TextRow>(session,
                                "SELECT token_id FROM one_shot_tokens WHERE " IS_FOR_TARGET,
                                soci::use(hash, "hash"),
                                soci::use(path, "path"),
                                soci::use(whole, "whole"),
                                soci::use(now_ms, "now"));
        if (owner) token = valid_token(session, *owner, now_ms);
    });
    return token;
}

std::optional<Token> TokenStore::redeem_one_shot(const std::string& secret,
                                                 const std::string& path,
                                                 const std::string& query) {
    std::optional<Token> token;
    catalog_.transaction([&](soci::session& session) {
        token = take_one_shot(session, secret, path, query, Catalog::now_ms(session));
    });
    return token;
}

}  // namespace divemesh::storage
