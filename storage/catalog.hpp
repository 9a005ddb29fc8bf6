#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>

namespace soci {
class session;
}

namespace divemesh::storage {

// The database behind all stores: SQLite (WAL, synchronous=FULL) at `sqlite:///path/catalog.db`, on
// a disk of this machine. It is the only engine there is. How it connects, locks and reports errors
// is in storage/sqlite_engine; the migrations are in its dialect (STRICT, RAISE, json_each), and so
// is a statement here and there (last_insert_rowid): a second engine has to change these too.
// Thread-safe: a pool of connections, one per call under way.
class Catalog {
public:
    using Work = std::function<void(soci::session&)>;

    // Opens or makes the database and brings its schema up to date (storage/migrations, compiled
    // in). Throws Error{Unavailable} when it cannot be opened, Error{Conflict} when it was written
    // by a newer version.
    explicit Catalog(const std::string& url);
    ~Catalog();
    Catalog(const Catalog&) = delete;
    Catalog& operator=(const Catalog&) = delete;

    // The same catalog for whoever must not wait: read() throws Error{Unavailable} where it would
    // have to, for a connection or for another process, and so does every transaction().
    Catalog read_nonblocking() const;
    // Opens connections until there are so many (16 at most): one for each thread that may ask, so
    // that read_nonblocking() finds one idle.
    void reserve(std::size_t num_connections);
    bool may_wait() const { return may_wait_; }
    // The same catalog for a change that leaves a note: `note` runs in every transaction, last.
    Catalog with_note(Work note) const;
    // The same for a change that depends on what is there: `check` runs in every transaction,
    // first, and may throw. Nobody else writes then, so it may read by the catalog itself.
    Catalog with_check(std::function<void()> check) const;

    // Runs `work` in one write transaction: committed when it returns, rolled back when it throws.
    void transaction(const Work& work);
    // The same for reading: one consistent snapshot.
    void read(const Work& work);

    // The catalog's own clock, unix milliseconds; leases are compared with nothing else.
    static std::int64_t now_ms(soci::session& session);
    int schema_version();
    // Throws Error{Unavailable} when its tables are not those of this version, and what a write
    // throws when it takes none.
    void require_writable();
    // A consistent copy as it is now, for a file that does not exist; others go on writing.
    void copy_to(const std::string& file);

private:
    struct Implementation;
    Catalog(std::shared_ptr<Implementation> implementation,
            bool may_wait,
            std::function<void()> check,
            Work note);

    std::shared_ptr<Implementation> implementation_;
    bool may_wait_ = true;
    std::function<void()> check_;  // empty: none
    Work note_;                    // empty: none
};

}  // namespace divemesh::storage
