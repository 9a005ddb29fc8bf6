#include "storage/catalog.hpp"

#include <algorithm>
#include <condition_variable>
#include <soci/soci.h>
#include <vector>

#include "schemas/error.hpp"
#include "storage/catalog_url.hpp"
#include "storage/engine.hpp"
#include "storage/fault_point.hpp"

namespace divemesh::storage {
namespace {

constexpr std::size_t kMaxConnections = 16;

std::unique_ptr<Engine> make_engine(const std::string& url, Opening opening) {
    static const std::string kSqlite = "sqlite://";
    if (url.starts_with(kSqlite)) return make_sqlite_engine(url.substr(kSqlite.size()), opening);
    if (is_postgresql_url(url)) return make_postgresql_engine(url);
    if (url.find("://") == std::string::npos) return make_sqlite_engine(url, opening);
    throw Error(ErrorCode::InvalidArgument,
                "cannot use the catalog " + without_password(url) +
                    ": give sqlite:///path/catalog.db or postgresql://user@host/database");
}

// The idle connections. A call takes one, or waits if too many are in use.
class Pool {
public:
    explicit Pool(const Engine& engine) : engine_(engine) {}

    std::unique_ptr<Session> take() {
        std::unique_lock lock(mutex_);
        returned_.wait(lock, [this] { return !idle_.empty() || num_open_ < kMaxConnections; });
        if (!idle_.empty()) {
            auto session = std::move(idle_.back());
            idle_.pop_back();
            return session;
        }
        ++num_open_;
        lock.unlock();
        try {
            return engine_.connect();
        } catch (...) {
            give_back(nullptr);
            throw;
        }
    }

    // Returns null if no connection is idle.
    std::unique_ptr<Session> take_idle() {
        const std::lock_guard lock(mutex_);
        if (idle_.empty()) return nullptr;
        auto session = std::move(idle_.back());
        idle_.pop_back();
        return session;
    }

    // Null: the connection can no longer be used.
    void give_back(std::unique_ptr<Session> session) {
        const std::lock_guard lock(mutex_);
        if (session)
            idle_.push_back(std::move(session));
        else
            --num_open_;
        returned_.notify_one();
    }

private:
    const Engine& engine_;
    std::mutex mutex_;
    std::condition_variable returned_;
    std::vector<std::unique_ptr<Session>> idle_;
    std::size_t num_open_ = 0;
};

// A connection from the pool with a transaction, which is rolled back unless committed.
class Transaction {
public:
    Transaction(const Engine& engine, Pool& pool, bool may_wait)
        : engine_(engine),
          pool_(pool),
          session_(may_wait ? pool.take() : pool.take_idle()),
          may_wait_(may_wait) {
        if (!session_)
            throw Error(ErrorCode::Unavailable, "no database connection is free: try again");
        if (!may_wait_) engine_.set_may_wait(*session_, false);
    }
    ~Transaction() {
        if (open_) {
            try {
                engine_.end(*session_, "ROLLBACK");
            } catch (const std::exception&) {
                session_.reset();  // SQLite rolled back by itself, or the connection is lost
            }
        }
        if (session_ && !may_wait_) engine_.set_may_wait(*session_, true);
        pool_.give_back(std::move(session_));
    }
    Transaction(const Transaction&) = delete;
    Transaction& operator=(const Transaction&) = delete;

    soci::session& session() { return *session_; }

    // An idle connection may have been lost, as by a restart of the database. Nothing has happened
    // on it yet, so a new one takes its place.
    template <typename Begin>
    void begin(const Begin& begin) {
        try {
            begin(*session_);
        } catch (const soci::soci_error&) {
            if (!engine_.is_lost(*session_)) throw;
            session_.reset();
            session_ = engine_.connect();
            begin(*session_);
        }
        open_ = true;
    }
    void commit() {
        fault_point();
        engine_.end(*session_, "COMMIT");
        open_ = false;
        fault_point();
    }

private:
    const Engine& engine_;
    Pool& pool_;
    std::unique_ptr<Session> session_;
    bool may_wait_;
    bool open_ = false;
};

}  // namespace

struct Catalog::Implementation {
    Implementation(const std::string& url, Opening opening)
        : shown_url(without_password(url)), engine(make_engine(url, opening)), pool(*engine) {}

    template <typename Begin>
    void run(bool may_wait, const Begin& begin, const Work& work) {
        try {
            Transaction transaction(*engine, pool, may_wait);
            transaction.begin(begin);
            work(transaction.session());
            transaction.commit();
        } catch (const soci::soci_error& error) {
            engine->translate(error);
            throw;
        }
    }

    // Runs `work` without a transaction, on a connection of its own.
    void run_alone(const Work& work) const {
        const auto session = engine->connect();
        try {
            work(*session);
        } catch (const soci::soci_error& error) {
            engine->translate(error);
            throw;
        }
    }

    bool is_current();
    void migrate(soci::session& session, Opening opening) const;

    std::string shown_url;
    std::unique_ptr<Engine> engine;
    Pool pool;
};

// Checked first, so that opening a catalog does not have to wait for its writers.
bool Catalog::Implementation::is_current() {
    try {
        int version = 0;
        const auto begin = [this](soci::session& session) { engine->begin_read(session); };
        run(true, begin, [&](soci::session& session) {
            session << "SELECT COALESCE(MAX(version), 0) FROM schema_version", soci::into(version);
        });
        return version == engine->migrations().newest_version();
    } catch (const soci::soci_error&) {
        return false;  // the table does not exist yet
    }
}

// If two processes start at the same time, the second waits for the transaction of the first.
void Catalog::Implementation::migrate(soci::session& session, Opening opening) const {
    if (opening == Opening::ExistingOnly && !engine->has_table(session, "schema_version"))
        throw Error(ErrorCode::Unavailable,
                    shown_url +
                        " is a database, but not a catalog: give the --catalog or "
                        "--data of the server");
    session << "CREATE TABLE IF NOT EXISTS schema_version (version INTEGER NOT NULL)";
    int version = 0;
    session << "SELECT COALESCE(MAX(version), 0) FROM schema_version", soci::into(version);
    const Migrations migrations = engine->migrations();
    const int newest = migrations.newest_version();
    if (version > newest)
        throw Error(
            ErrorCode::Conflict,
            "the catalog was written by a newer version (schema " + std::to_string(version) +
                ", this version knows " + std::to_string(newest) +
                "): install the newer version, or restore a backup made before the upgrade");
    if (version == newest) return;
    for (int next = std::max(version + 1, migrations.first_version); next <= newest; ++next)
        engine->run_script(
            session, migrations.scripts[static_cast<std::size_t>(next - migrations.first_version)]);
    session << "DELETE FROM schema_version";
    session << "INSERT INTO schema_version (version) VALUES (:version)", soci::use(newest);
}

Catalog::Catalog(const std::string& url, Opening opening)
    : implementation_(new Implementation(url, opening)) {
    if (implementation_->is_current()) return;
    transaction([&](soci::session& session) { implementation_->migrate(session, opening); });
}

Catalog::Catalog(std::shared_ptr<Implementation> implementation,
                 bool may_wait,
                 std::function<void()> check,
                 Work audit)
    : implementation_(std::move(implementation)),
      may_wait_(may_wait),
      check_(std::move(check)),
      audit_(std::move(audit)) {}

Catalog::~Catalog() = default;

Catalog Catalog::read_nonblocking() const { return {implementation_, false, check_, audit_}; }

void Catalog::reserve(std::size_t num_connections) {
    Pool& pool = implementation_->pool;
    std::vector<std::unique_ptr<Session>> taken;
    while (taken.size() < std::min(num_connections, kMaxConnections)) taken.push_back(pool.take());
    for (auto& session : taken) pool.give_back(std::move(session));
}

Catalog Catalog::with_audit(Work audit) const {
    return {implementation_, may_wait_, check_, std::move(audit)};
}

Catalog Catalog::with_check(std::function<void()> check) const {
    return {implementation_, may_wait_, std::move(check), audit_};
}

void Catalog::transaction(const Work& work) {
    // Another writer may be syncing a disk.
    if (!may_wait_)
        throw Error(ErrorCode::Unavailable, "the catalog cannot be written now: try again");
    Engine& engine = *implementation_->engine;
    const auto turn = engine.wait_for_write_lock();
    const auto begin = [&](soci::session& session) { engine.begin_write(session); };
    implementation_->run(true, begin, [&](soci::session& session) {
        if (check_) check_();
        work(session);
        if (audit_) audit_(session);
    });
}

void Catalog::read(const Work& work) {
    const Engine& engine = *implementation_->engine;
    if (!may_wait_ && !engine.is_local())
        throw Error(ErrorCode::Unavailable, "the catalog is read across a network: wait for it");
    const auto begin = [&](soci::session& session) { engine.begin_read(session); };
    implementation_->run(may_wait_, begin, work);
}

std::int64_t Catalog::now_ms(soci::session& session) {
    std::int64_t now_ms = 0;
    session << dialect_of(session).clock_query, soci::into(now_ms);
    return now_ms;
}

int Catalog::schema_version() {
    int version = 0;
    read([&](soci::session& session) {
        session << "SELECT MAX(version) FROM schema_version", soci::into(version);
    });
    return version;
}

void Catalog::require_writable() {
    const int version = schema_version();
    const int newest = implementation_->engine->migrations().newest_version();
    if (version != newest)
        throw Error(ErrorCode::Unavailable,
                    "its schema is " + std::to_string(version) + ", but this version needs " +
                        std::to_string(newest) + ": restart with the version that wrote it");
    transaction(
        [](soci::session& session) { session << "UPDATE schema_version SET version = version"; });
}

void Catalog::copy_to(const std::string& file) {
    implementation_->run_alone(
        [&](soci::session& session) { implementation_->engine->copy_to(session, file); });
}

void Catalog::checkpoint() {
    implementation_->run_alone(
        [this](soci::session& session) { implementation_->engine->checkpoint(session); });
}

}  // namespace divemesh::storage
