#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "storage/opening.hpp"

namespace soci {
class session;
}

namespace divemesh::storage {

// The database behind all stores: SQLite (WAL, synchronous=FULL) at `sqlite:///path/catalog.db`, on
// a local disk, or PostgreSQL at `postgresql://user@host/database`. How an engine connects, locks
// and reports errors is in storage/sqlite_engine and storage/postgresql_engine; storage/engine.hpp
// says what all of them promise.
// Thread-safe: a pool of connections, one per call under way.
class Catalog {
public:
    using Work = std::function<void(soci::session&)>;

    // Opens or creates the database and brings its schema up to date (storage/migrations, compiled
    // in). Throws Error{Unavailable} if it cannot be opened, or is not there and may not be
    // created; Error{Conflict} if a newer version wrote it.
    explicit Catalog(const std::string& url, Opening opening = Opening::CreateIfMissing);
    ~Catalog();
    Catalog(const Catalog&) = delete;
    Catalog& operator=(const Catalog&) = delete;

    // Returns the same catalog for callers that must not wait. Its read() throws Error{Unavailable}
    // where it would wait for a connection, for another process or, with PostgreSQL always, for a
    // network; its transaction() always throws it.
    Catalog read_nonblocking() const;
    // Opens connections until there are `num_connections` (16 at most): one for each thread that
    // reads, so that read_nonblocking() finds an idle one.
    void reserve(std::size_t num_connections);
    bool may_wait() const { return may_wait_; }
    // Returns the same catalog for audited changes: `audit` runs last in every transaction.
    Catalog with_audit(Work audit) const;
    // Returns the same catalog for conditional changes: `check` runs first in every transaction and
    // may throw. No other writer runs then, so it may read by the catalog itself.
    Catalog with_check(std::function<void()> check) const;

    // Runs `work` in one write transaction: committed when it returns, rolled back if it throws.
    void transaction(const Work& work);
    // Runs `work` in one read transaction: it sees one consistent snapshot.
    void read(const Work& work);

    // Returns the catalog's own clock in unix milliseconds; leases are compared only with this
    // clock.
    static std::int64_t now_ms(soci::session& session);
    int schema_version();
    // Checks that the catalog accepts a write. Throws Error{Unavailable} if its tables are not
    // those of this version, and what a failed write throws.
    void require_writable();
    // Writes a consistent copy of the current state to a file that does not exist yet; other calls
    // may write meanwhile. Throws Error{Unsupported} for PostgreSQL, which has pg_dump.
    void copy_to(const std::string& file);
    // Moves all changes into the catalog's own file, durably, so that the file may be copied or
    // renamed by itself. Throws Error{Unavailable}, also if another process uses the catalog.
    void checkpoint();

private:
    struct Implementation;
    Catalog(std::shared_ptr<Implementation> implementation,
            bool may_wait,
            std::function<void()> check,
            Work audit);

    std::shared_ptr<Implementation> implementation_;
    bool may_wait_ = true;
    std::function<void()> check_;  // may be empty
    Work audit_;                   // may be empty
};

}  // namespace divemesh::storage
