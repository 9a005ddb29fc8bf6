#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <soci/soci.h>
#include <string>

#include "storage/session.hpp"

namespace divemesh::storage {

// What a database does in its own way beside SQL. The migrations are SQLite's alone.
class Engine {
public:
    virtual ~Engine() = default;

    virtual std::unique_ptr<Session> connect() const = 0;
    // Held for the length of a write transaction by engines that have one writer at a time.
    virtual std::unique_lock<std::mutex> wait_for_write_lock() = 0;
    virtual void begin_write(soci::session& session) const = 0;
    virtual void begin_read(soci::session& session) const = 0;
    virtual void end(soci::session& session, const char* how) const = 0;  // COMMIT, ROLLBACK
    // Whether calls on this connection wait for other processes; they do when it is new.
    virtual void set_may_wait(soci::session& session, bool may_wait) const = 0;
    virtual void run_script(soci::session& session, const std::string& sql) const = 0;
    // Into a file that is not there, or is empty and keeps its mode.
    virtual void copy_to(soci::session& session, const std::string& file) const = 0;
    // Throws Error{Unavailable} or Error{OutOfSpace} for what is no bug of ours; else returns.
    virtual void translate(const soci::soci_error& error) const = 0;
};

// Throws Error{InvalidArgument} for a URL of a database we do not speak.
std::unique_ptr<Engine> make_sqlite_engine(const std::string& file);

// The query that reads the database's clock in unix milliseconds.
inline const char* clock_query(const soci::session& session) {
    return session.get_backend_name() == "sqlite3"
               ? "SELECT CAST((julianday('now') - 2440587.5) * 86400000.0 AS INTEGER)"
               : "SELECT CAST(EXTRACT(EPOCH FROM clock_timestamp()) * 1000 AS BIGINT)";
}

}  // namespace divemesh::storage
