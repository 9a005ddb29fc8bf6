#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>

namespace soci {
class session;
}

namespace divemesh::storage {

// The database behind all stores: SQLite (WAL, synchronous=FULL) at `sqlite:///path/catalog.db`.
// The engine shows nowhere else: a second one is a second implementation of this class's few
// private differences, and the stores' SQL and tests stay as they are. Thread-safe: a pool of
// connections, one per call under way.
class Catalog {
public:
    // Opens or makes the database and brings its schema up to date (storage/migrations, compiled
    // in). Throws Error{Unavailable} when it cannot be opened, Error{Conflict} when it was written
    // by a newer version.
    explicit Catalog(const std::string& url);
    ~Catalog();
    Catalog(const Catalog&) = delete;
    Catalog& operator=(const Catalog&) = delete;

    // Runs `work` in one write transaction: committed when it returns, rolled back when it throws.
    void transaction(const std::function<void(soci::session&)>& work);
    // The same for reading: one consistent snapshot.
    void read(const std::function<void(soci::session&)>& work);

    // The catalog's own clock, unix milliseconds; leases are compared with nothing else.
    static std::int64_t now_ms(soci::session& session);
    int schema_version();
    // A consistent copy as it is now, for a file that does not exist; others go on writing.
    void copy_to(const std::string& file);

private:
    struct Implementation;
    std::unique_ptr<Implementation> implementation_;
};

}  // namespace divemesh::storage
