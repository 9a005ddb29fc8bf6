#include "storage/worker_store.hpp"

#include "schemas/error.hpp"
#include "storage/sql.hpp"

namespace divemesh::storage {
namespace {

constexpr std::int64_t kForgotten_ms = 86'400'000;

struct WorkerRow {
    Worker worker;
    int draining = 0;
    int alive = 0;

    void define(soci::statement& statement) {
        define_columns(statement,
                       worker.name,
                       worker.num_slots,
                       worker.num_running,
                       draining,
                       alive,
                       worker.waits_for,
                       worker.started_at_ms,
                       worker.seen_at_ms);
    }
    Worker value() const {
        Worker value = worker;
        value.draining = draining != 0;
        value.alive = alive != 0;
        return value;
    }
};

// `name` "": all workers.
std::vector<Worker> read_workers(soci::session& session, const std::string& name) {
    const std::int64_t alive_since_ms = Catalog::now_ms(session) - kWorkerSilence_ms;
    return select_all<WorkerRow>(
        session,
        "SELECT name, num_slots,"
        " (SELECT COUNT(*) FROM attempts WHERE worker = name AND state = 'running'),"
        " draining, CASE WHEN seen_at_ms >= :alive THEN 1 ELSE 0 END, waits_for,"
        " started_at_ms, seen_at_ms"
        " FROM workers WHERE (:name = '' OR name = :name) ORDER BY name",
        soci::use(alive_since_ms, "alive"),
        soci::use(name, "name"));
}

}  // namespace

void WorkerStore::report(const std::string& name, int num_slots, const std::string& waits_for) {
    catalog_.transaction([&](soci::session& session) {
        const std::int64_t now_ms = Catalog::now_ms(session);
        const std::int64_t forgotten_ms = now_ms - kForgotten_ms;
        execute(session,
                "DELETE FROM workers WHERE seen_at_ms < :forgotten",
                soci::use(forgotten_ms, "forgotten"));
        execute(session,
                "INSERT INTO workers (name, num_slots, waits_for, started_at_ms, seen_at_ms)"
                " VALUES (:name, :slots, :waits_for, :now, :now)"
                " ON CONFLICT (name) DO UPDATE SET seen_at_ms = excluded.seen_at_ms,"
                " waits_for = excluded.waits_for",
                soci::use(name, "name"),
                soci::use(num_slots, "slots"),
                soci::use(waits_for, "waits_for"),
                soci::use(now_ms, "now"));
    });
}

void WorkerStore::remove(const std::string& name) {
    catalog_.transaction([&](soci::session& session) {
        execute(session, "DELETE FROM workers WHERE name = :name", soci::use(name, "name"));
    });
}

void WorkerStore::forget_silent(std::chrono::milliseconds silence) {
    const std::string forgotten = " FROM workers WHERE seen_at_ms < :since AND draining = 0";
    std::int64_t since_ms = 0;
    bool is_any = false;
    catalog_.read([&](soci::session& session) {
        since_ms = Catalog::now_ms(session) - silence.count();
        is_any = select_one<TextRow>(
                     session, "SELECT name" + forgotten + " LIMIT 1", soci::use(since_ms, "since"))
                     .has_value();
    });
    if (!is_any) return;  // most of the time, and without the write lock
    catalog_.transaction([&](soci::session& session) {
        execute(session, "DELETE" + forgotten, soci::use(since_ms, "since"));
    });
}

std::vector<Worker> WorkerStore::list() {
    std::vector<Worker> workers;
    catalog_.read([&](soci::session& session) { workers = read_workers(session, ""); });
    return workers;
}

Worker WorkerStore::get(const std::string& name) {
    std::vector<Worker> found;
    catalog_.read([&](soci::session& session) { found = read_workers(session, name); });
    if (name.empty() || found.empty()) throw Error(ErrorCode::NotFound, "no worker " + name);
    return found.front();
}

Worker WorkerStore::set_draining(const std::string& name, bool draining) {
    const int flag = draining ? 1 : 0;
    catalog_.transaction([&](soci::session& session) {
        execute(session,
                "UPDATE workers SET draining = :draining WHERE name = :name",
                soci::use(flag, "draining"),
                soci::use(name, "name"));
    });
    return get(name);
}

}  // namespace divemesh::storage
