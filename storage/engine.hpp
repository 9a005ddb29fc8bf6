#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <soci/soci.h>
#include <string>

#include "storage/opening.hpp"
#include "storage/session.hpp"

namespace divemesh::storage {

// What differs between databases besides SQL. The migrations are written for SQLite only.
class Engine {
public:
    virtual ~Engine() = default;

    virtual std::unique_ptr<Session> connect() const = 0;
    // Returns a lock to hold during a write transaction, for engines that allow one writer at a
    // time.
    virtual std::unique_lock<std::mutex> wait_for_write_lock() = 0;
    virtual void begin_write(soci::session& session) const = 0;
    virtual void begin_read(soci::session& session) const = 0;
    virtual void end(soci::session& session, const char* how) const = 0;  // COMMIT, ROLLBACK
    // Sets whether calls on this connection wait for other processes; a new connection waits.
    virtual void set_may_wait(soci::session& session, bool may_wait) const = 0;
    virtual void run_script(soci::session& session, const std::string& sql) const = 0;
    // Copies the database into a file that does not exist, or is empty and keeps its mode.
    virtual void copy_to(soci::session& session, const std::string& file) const = 0;
    // Moves what is in the log into the database's own file, durably.
    virtual void checkpoint(soci::session& session) const = 0;
    // Throws Error{Unavailable} or Error{OutOfSpace} for an error that is not a bug; otherwise
    // returns.
    virtual void translate(const soci::soci_error& error) const = 0;
};

// Throws Error{InvalidArgument} for the URL of an unsupported database.
std::unique_ptr<Engine> make_sqlite_engine(const std::string& file, Opening opening);

// Returns the query for the database's clock in unix milliseconds.
inline const char* clock_query(const soci::session& session) {
    return session.get_backend_name() == "sqlite3"
               ? "SELECT CAST((julianday('now') - 2440587.5) * 86400000.0 AS INTEGER)"
               : "SELECT CAST(EXTRACT(EPOCH FROM clock_timestamp()) * 1000 AS BIGINT)";
}

}  // namespace divemesh::storage
