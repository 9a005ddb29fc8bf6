#include <chrono>
#include <cstring>
#include <fcntl.h>
#include <filesystem>
#include <soci/sqlite3/soci-sqlite3.h>
#include <thread>

#include "schemas/error.hpp"
#include "schemas/file_descriptor.hpp"
#include "storage/engine.hpp"
#include "storage/migrations/sqlite.hpp"

namespace divemesh::storage {
namespace {

constexpr int kBusyTimeoutSeconds = 15;
constexpr Dialect kDialect{
    .clock_query = "SELECT CAST((julianday('now') - 2440587.5) * 86400000.0 AS INTEGER)",
    .text_holds_any_bytes = true,
    .bytes_are_blobs = true,
    .keeps_statements = false};

sqlite_api::sqlite3* connection_of(soci::session& session) {
    return static_cast<soci::sqlite3_session_backend*>(session.get_backend())->conn_;
}

class SqliteEngine : public Engine {
public:
    SqliteEngine(std::string file, Opening opening) : file_(std::move(file)) {
        if (opening == Opening::CreateIfMissing)
            make_file();
        else
            require_file();
    }

    std::unique_ptr<Session> connect() const override {
        try {
            auto session = std::make_unique<Session>(
                kDialect,
                soci::sqlite3,
                "dbname=\"" + file_ + "\" timeout=" + std::to_string(kBusyTimeoutSeconds));
            switch_to_wal(*session);
            *session << "PRAGMA synchronous = FULL";
            *session << "PRAGMA foreign_keys = ON";
            return session;
        } catch (const soci::soci_error& error) {
            translate(error);
            throw;
        }
    }

    // SQLite has one writer at a time. Threads of one process queue here; only for other processes
    // it polls.
    std::unique_lock<std::mutex> wait_for_write_lock() override {
        return std::unique_lock(writer_);
    }

    // Immediate, because a transaction that reads first and writes later could otherwise fail half
    // way.
    void begin_write(soci::session& session) const override { execute(session, "BEGIN IMMEDIATE"); }
    void begin_read(soci::session& session) const override { execute(session, "BEGIN"); }
    void end(soci::session& session, const char* how) const override { execute(session, how); }

    bool is_lost(soci::session&) const override { return false; }
    bool is_local() const override { return true; }
    void set_may_wait(soci::session& session, bool may_wait) const override {
        sqlite_api::sqlite3_busy_timeout(connection_of(session),
                                         may_wait ? 1000 * kBusyTimeoutSeconds : 0);
    }

    Migrations migrations() const override { return {.scripts = sqlite_scripts()}; }
    bool has_table(soci::session& session, const std::string& name) const override {
        int count = 0;
        session << "SELECT COUNT(*) FROM sqlite_master WHERE name = :name", soci::into(count),
            soci::use(name, "name");
        return count > 0;
    }
    void run_script(soci::session& session, const std::string& sql) const override {
        execute(session, sql.c_str());
    }

    // Reads one snapshot; the copy has no free pages and no write-ahead log.
    void copy_to(soci::session& session, const std::string& file) const override {
        session << "VACUUM INTO :file", soci::use(file);
    }

    // SQLite does the same when the last connection closes, but does not say if that fails.
    void checkpoint(soci::session& session) const override {
        int is_busy = 0;
        session << "PRAGMA wal_checkpoint(TRUNCATE)", soci::into(is_busy);
        if (is_busy != 0)
            throw Error(ErrorCode::Unavailable,
                        "the catalog " + file_ + " is in use by another process: try again");
    }

    void translate(const soci::soci_error& error) const override {
        const auto* failure = dynamic_cast<const soci::sqlite3_soci_error*>(&error);
        if (!failure) return;
        switch (failure->result() & 0xff) {  // the rest is the extended code
            case SQLITE_BUSY:
            case SQLITE_LOCKED:
                throw Error(ErrorCode::Unavailable, "the catalog is busy: try again");
            case SQLITE_FULL:
                throw Error(ErrorCode::OutOfSpace,
                            "there is no space left for the catalog " + file_ +
                                ": free some space and try again");
            case SQLITE_IOERR:
            case SQLITE_CANTOPEN:
            case SQLITE_READONLY:
                throw Error(ErrorCode::Unavailable,
                            "cannot read or write the catalog " + file_ + ": " + error.what());
            case SQLITE_CORRUPT:
            case SQLITE_NOTADB:
                throw Error(ErrorCode::Unavailable,
                            file_ + " is not a catalog or is damaged: restore it from a backup");
            default: return;
        }
    }

private:
    static void execute(soci::session& session, const char* sql) {
        char* message = nullptr;
        const int result =
            sqlite_api::sqlite3_exec(connection_of(session), sql, nullptr, nullptr, &message);
        const std::string text = message ? message : "";
        sqlite_api::sqlite3_free(message);
        if (result != SQLITE_OK) throw soci::sqlite3_soci_error(text, result);
    }

    // Creates the file here, so that other users cannot read it: it holds the tokens' hashes.
    void make_file() const {
        std::error_code failure;
        const auto folder = std::filesystem::path(file_).parent_path();
        if (!folder.empty()) std::filesystem::create_directories(folder, failure);
        const FileDescriptor file(open(file_.c_str(), O_CREAT | O_EXCL | O_RDWR | O_CLOEXEC, 0660));
        if (!file.is_open() && errno != EEXIST)
            throw Error(ErrorCode::Unavailable,
                        "cannot create the catalog " + file_ + ": " + std::strerror(errno));
    }

    // An empty file is no catalog either, but SQLite would make one of it.
    void require_file() const {
        std::error_code failure;
        if (std::filesystem::file_size(file_, failure) > 0 && !failure) return;
        throw Error(ErrorCode::Unavailable,
                    "there is no catalog " + std::filesystem::absolute(file_).string() +
                        ": give the --catalog or --data of the server, mount its disk, or start "
                        "the server first, which creates it");
    }

    // SQLite refuses the switch, without waiting, while another process does it.
    static void switch_to_wal(soci::session& session) {
        const auto give_up =
            std::chrono::steady_clock::now() + std::chrono::seconds(kBusyTimeoutSeconds);
        for (;;) {
            try {
                std::string mode;
                session << "PRAGMA journal_mode = WAL", soci::into(mode);
                return;
            } catch (const soci::sqlite3_soci_error& error) {
                const bool busy = (error.result() & 0xff) == SQLITE_BUSY;
                if (!busy || std::chrono::steady_clock::now() > give_up) throw;
            }
            std::this_thread::sleep_for(std::chrono::milliseconds(20));
        }
    }

    std::string file_;
    std::mutex writer_;
};

}  // namespace

std::unique_ptr<Engine> make_sqlite_engine(const std::string& file, Opening opening) {
    if (file.empty() || file.find('"') != std::string::npos)
        throw Error(ErrorCode::InvalidArgument,
                    "this is not a file name for a catalog: '" + file + "'");
    return std::make_unique<SqliteEngine>(file, opening);
}

}  // namespace divemesh::storage
