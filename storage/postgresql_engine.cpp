#include <algorithm>
#include <array>
#include <cstring>
#include <libpq-fe.h>
#include <memory>
#include <soci/postgresql/soci-postgresql.h>
#include <string_view>
#include <utility>

#include "schemas/error.hpp"
#include "storage/engine.hpp"
#include "storage/migrations/postgresql.hpp"

namespace divemesh::storage {
namespace {

constexpr Dialect kDialect{
    .clock_query = "SELECT CAST(EXTRACT(EPOCH FROM clock_timestamp()) * 1000 AS BIGINT)",
    .text_holds_any_bytes = false,
    .bytes_are_blobs = false,
    .keeps_statements = true};

// The one writer holds the advisory lock with this number: any number will do that all versions
// share.
constexpr const char* kBeginWrite =
    "BEGIN ISOLATION LEVEL READ COMMITTED; SELECT pg_advisory_xact_lock(4417280912)";

// A writer waits for another one as long as with SQLite. A process that stops in the middle of a
// transaction loses it after 10 s, so that the others go on. Durability is not left to a setting of
// the server that gives it up.
constexpr const char* kSetUp =
    "SET client_encoding = 'UTF8';"
    "SET lock_timeout = '15s';"
    "SET statement_timeout = '60s';"
    "SET idle_in_transaction_session_timeout = '10s';"
    "SELECT set_config('synchronous_commit', 'on', false)"
    " WHERE current_setting('synchronous_commit') = 'off'";

// What a URL may set itself: a peer that has vanished is noticed within some 10 s.
constexpr std::array<std::pair<std::string_view, const char*>, 6> kDefaults = {{
    {"connect_timeout", "10"},
    {"keepalives_idle", "10"},
    {"keepalives_interval", "3"},
    {"keepalives_count", "3"},
    {"tcp_user_timeout", "10000"},
    {"application_name", "divemesh"},
}};

using Options = std::unique_ptr<PQconninfoOption, decltype(&PQconninfoFree)>;
using Result = std::unique_ptr<PGresult, decltype(&PQclear)>;

PGconn* connection_of(soci::session& session) {
    return static_cast<soci::postgresql_session_backend*>(session.get_backend())->conn_;
}

// Quotes a value for a connection string.
std::string quoted(std::string_view value) {
    std::string text = "'";
    for (const char c : value) {
        if (c == '\'' || c == '\\') text += '\\';
        text += c;
    }
    return text + "' ";
}

// libpq's own message may repeat the password.
std::string connection_string(const std::string& url) {
    const Options options(PQconninfoParse(url.c_str(), nullptr), PQconninfoFree);
    if (!options)
        throw Error(ErrorCode::InvalidArgument,
                    "this is not the URL of a PostgreSQL catalog: give "
                    "postgresql://user@host:5432/database, with %40 for an @ in a password");
    std::string connection;
    for (const PQconninfoOption* option = options.get(); option->keyword != nullptr; ++option) {
        const auto* const usual =
            std::find_if(kDefaults.begin(), kDefaults.end(), [&](const auto& setting) {
                return setting.first == option->keyword;
            });
        const char* value = option->val;
        if (value == nullptr && usual != kDefaults.end()) value = usual->second;
        if (value != nullptr) connection += std::string(option->keyword) + "=" + quoted(value);
    }
    return connection;
}

void ignore_notice(void*, const char*) {}

// Returns the text up to its first line break.
std::string first_line(const std::string& text) { return text.substr(0, text.find('\n')); }

// Runs statements without parameters, and throws what SOCI would throw for its own.
Result run(soci::session& session, const char* sql) {
    PGconn* connection = connection_of(session);
    Result result(PQexec(connection, sql), PQclear);
    const ExecStatusType status = PQresultStatus(result.get());
    if (status == PGRES_COMMAND_OK || status == PGRES_TUPLES_OK) return result;
    const char* code = PQresultErrorField(result.get(), PG_DIAG_SQLSTATE);
    throw soci::postgresql_soci_error(PQerrorMessage(connection), code ? code : "     ");
}

bool is_one_of(std::string_view state, std::initializer_list<std::string_view> states) {
    return std::any_of(
        states.begin(), states.end(), [&](auto prefix) { return state.starts_with(prefix); });
}

// Throws the Error for a SQLSTATE (appendix A of PostgreSQL's manual) that is not a bug.
void throw_known(std::string_view state, const std::string& message) {
    if (is_one_of(state, {"     ", "08", "25P03", "57P01", "57P02", "57P03", "57P05"}))
        throw Error(ErrorCode::Unavailable,
                    "the connection to PostgreSQL was lost: if this was a change, look whether it "
                    "was made, then try again");
    if (is_one_of(state, {"40", "55P03", "57014"}))
        throw Error(ErrorCode::Unavailable, "the catalog is busy: try again");
    if (is_one_of(state, {"53100"}))
        throw Error(ErrorCode::OutOfSpace,
                    "there is no space left for the catalog on PostgreSQL's disk: free some space "
                    "and try again");
    if (is_one_of(state, {"25006"}))
        throw Error(ErrorCode::Unavailable,
                    "PostgreSQL takes no changes, because this server is a standby or was made "
                    "read-only: give the address of the primary in --catalog, or all addresses "
                    "with target_session_attrs=read-write");
    if (is_one_of(state, {"28", "3D", "42501", "53", "58", "XX"}))
        throw Error(ErrorCode::Unavailable,
                    "PostgreSQL cannot read or write the catalog: " + first_line(message));
}

class PostgresqlEngine : public Engine {
public:
    explicit PostgresqlEngine(const std::string& url) : connection_(connection_string(url)) {}

    std::unique_ptr<Session> connect() const override {
        try {
            auto session = std::make_unique<Session>(kDialect, soci::postgresql, connection_);
            PGconn* connection = connection_of(*session);
            PQsetNoticeProcessor(connection, ignore_notice, nullptr);
            run(*session, kSetUp);
            const char* encoding = PQparameterStatus(connection, "server_encoding");
            if (encoding == nullptr || std::strcmp(encoding, "UTF8") != 0)
                throw Error(ErrorCode::InvalidArgument,
                            std::string("the database ") + PQdb(connection) +
                                " does not hold UTF-8: create another one with `createdb "
                                "--encoding=UTF8 --template=template0`");
            return session;
        } catch (const soci::soci_error& error) {
            throw Error(ErrorCode::Unavailable,
                        "cannot open the catalog in PostgreSQL: " + reason_of(error.what()) +
                            ": check that it runs, and the address, user and database in "
                            "--catalog");
        }
    }

    // All writers wait for one lock, so more than one of them would only keep connections from
    // those who read.
    std::unique_lock<std::mutex> wait_for_write_lock() override {
        return std::unique_lock(writer_);
    }

    // Each statement sees what was committed before it, and with the lock nothing is committed in
    // between.
    void begin_write(soci::session& session) const override { begin(session, kBeginWrite); }
    void begin_read(soci::session& session) const override {
        begin(session, "BEGIN ISOLATION LEVEL REPEATABLE READ READ ONLY");
    }

    // A transaction in which a statement has failed ends with ROLLBACK, whatever is asked for.
    void end(soci::session& session, const char* how) const override {
        // A timeout that ends the wait for a standby would leave the change on this server alone.
        const bool commits = std::strcmp(how, "COMMIT") == 0;
        const Result result =
            run(session, commits ? "SET LOCAL statement_timeout = 0; COMMIT" : how);
        if (std::strcmp(PQcmdStatus(result.get()), how) != 0)
            throw soci::soci_error("a transaction with a failed statement was to be committed");
    }

    bool is_lost(soci::session& session) const override {
        return PQstatus(connection_of(session)) != CONNECTION_OK;
    }
    bool is_local() const override { return false; }
    void set_may_wait(soci::session&, bool) const override {}

    Migrations migrations() const override {
        return {.first_version = 24, .scripts = postgresql_scripts()};
    }
    bool has_table(soci::session& session, const std::string& name) const override {
        int count = 0;
        session << "SELECT COUNT(*) FROM pg_class WHERE oid = to_regclass(:name)",
            soci::into(count), soci::use(name, "name");
        return count > 0;
    }
    void run_script(soci::session& session, const std::string& sql) const override {
        run(session, "SET LOCAL statement_timeout = 0");
        run(session, sql.c_str());
    }

    void copy_to(soci::session&, const std::string&) const override {
        throw Error(ErrorCode::Unsupported,
                    "only a catalog in SQLite is copied into one file: copy this one with pg_dump, "
                    "then the blobs (docs/operation.md)");
    }
    void checkpoint(soci::session&) const override {}

    void translate(const soci::soci_error& error) const override {
        const auto* failure = dynamic_cast<const soci::postgresql_soci_error*>(&error);
        if (failure) throw_known(failure->sqlstate(), failure->what());
    }

private:
    static void begin(soci::session& session, const char* sql) {
        try {
            run(session, sql);
        } catch (const soci::soci_error&) {
            PQclear(PQexec(connection_of(session), "ROLLBACK"));  // it may have begun
            throw;
        }
    }

    // SOCI puts a line of its own before libpq's.
    static std::string reason_of(const std::string& message) {
        const auto second = message.find('\n');
        return first_line(second == std::string::npos ? message : message.substr(second + 1));
    }

    std::string connection_;
    std::mutex writer_;
};

}  // namespace

std::unique_ptr<Engine> make_postgresql_engine(const std::string& url) {
    return std::make_unique<PostgresqlEngine>(url);
}

}  // namespace divemesh::storage
