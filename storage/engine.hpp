#pragma once

#include <memory>
#include <mutex>
#include <soci/soci.h>
#include <string>

#include "storage/migrations.hpp"
#include "storage/opening.hpp"
#include "storage/session.hpp"

namespace divemesh::storage {

// What differs between databases besides SQL. An engine promises:
// - One writer: between begin_write() and end() no other transaction writes, of any thread, process
//   or machine. What a write transaction reads stays true until it ends. All checks of the stores
//   rely on this: claims, quotas, keys that were used before, states.
// - Durable: what COMMIT has accepted survives the loss of power.
// - One snapshot: all reads of a read transaction see the same state, and no writer waits for it.
// - Clean ends: a transaction that fails, or whose process dies, leaves nothing.
class Engine {
public:
    virtual ~Engine() = default;

    virtual std::unique_ptr<Session> connect() const = 0;
    // Returns a lock to hold during a write transaction, so that the threads of this process queue
    // here and take one connection to the database's own lock at a time.
    virtual std::unique_lock<std::mutex> wait_for_write_lock() = 0;
    virtual void begin_write(soci::session& session) const = 0;
    virtual void begin_read(soci::session& session) const = 0;
    virtual void end(soci::session& session, const char* how) const = 0;  // COMMIT, ROLLBACK
    // Returns whether the connection cannot be used any more.
    virtual bool is_lost(soci::session& session) const = 0;
    // Returns whether reads need nothing but this machine, so that they can be non-blocking.
    virtual bool is_local() const = 0;
    // Sets whether calls on this connection wait for other processes; a new connection waits.
    virtual void set_may_wait(soci::session& session, bool may_wait) const = 0;

    virtual Migrations migrations() const = 0;
    virtual bool has_table(soci::session& session, const std::string& name) const = 0;
    virtual void run_script(soci::session& session, const std::string& sql) const = 0;

    // Copies the database into a file that does not exist, or is empty and keeps its mode. Throws
    // Error{Unsupported} if the database has a tool of its own for it.
    virtual void copy_to(soci::session& session, const std::string& file) const = 0;
    // Moves what is in the log into the database's own file, durably.
    virtual void checkpoint(soci::session& session) const = 0;
    // Throws Error{Unavailable} or Error{OutOfSpace} for an error that is not a bug; otherwise
    // returns.
    virtual void translate(const soci::soci_error& error) const = 0;
};

// Throws Error{InvalidArgument} for the name of no file.
std::unique_ptr<Engine> make_sqlite_engine(const std::string& file, Opening opening);
// Throws Error{InvalidArgument} for a URL that libpq does not understand.
std::unique_ptr<Engine> make_postgresql_engine(const std::string& url);

}  // namespace divemesh::storage
