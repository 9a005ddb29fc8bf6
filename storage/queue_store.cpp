#include "storage/queue_store.hpp"

#include "schemas/error.hpp"
#include "schemas/job_state.hpp"
#include "storage/sql.hpp"
#include "storage/wait_reasons.hpp"

namespace divemesh::storage {
namespace {

struct QueueRow {
    Queue queue;
    int paused = 0;

    void define(soci::statement& statement) {
        define_columns(statement, queue.project, paused, queue.max_running, queue.keep_results);
    }
    Queue value() const {
        Queue value = queue;
        value.paused = paused != 0;
        return value;
    }
};

Queue read_queue(soci::session& session, const std::string& project) {
    Queue queue =
        select_one<QueueRow>(session,
                             "SELECT project, paused, max_running, keep_results FROM queues"
                             " WHERE project = :project",
                             soci::use(project, "project"))
            .value_or(Queue{.project = project});
    for (const JobState state : kJobStates) queue.num_jobs[std::string(to_string(state))] = 0;
    for (const auto& [state, count] :
         select_all<CountRow>(session,
                              "SELECT state, COUNT(*) FROM jobs"
                              " WHERE (:project = '' OR project = :project) GROUP BY state",
                              soci::use(project, "project")))
        queue.num_jobs[state] = count;
    return queue;
}

}  // namespace

Queue QueueStore::get(const std::string& project) {
    Queue queue;
    catalog_.read([&](soci::session& session) { queue = read_queue(session, project); });
    return queue;
}

std::string QueueStore::waits_for() {
    std::string reason;
    catalog_.read([&](soci::session& session) { reason = WaitReasons(session).of_queue(); });
    return reason;
}

Queue QueueStore::change(const std::string& project, const QueueChange& change) {
    if (change.max_running.value_or(0) < 0)
        throw Error(ErrorCode::InvalidArgument,
                    "max_running is less than 0: give 0 for no limit, or more");
    if (change.keep_results.value_or(0) < 0)
        throw Error(ErrorCode::InvalidArgument,
                    "keep_results is less than 0: give 0 to keep all, or more");
    Queue queue;
    catalog_.transaction([&](soci::session& session) {
        queue = read_queue(session, project);
        queue.paused = change.paused.value_or(queue.paused);
        queue.max_running = change.max_running.value_or(queue.max_running);
        queue.keep_results = change.keep_results.value_or(queue.keep_results);
        const int paused = queue.paused ? 1 : 0;
        execute(session,
                "INSERT INTO queues (project, paused, max_running, keep_results)"
                " VALUES (:project, :paused, :limit, :keep) ON CONFLICT (project) DO UPDATE SET"
                " paused = excluded.paused, max_running = excluded.max_running,"
                " keep_results = excluded.keep_results",
                soci::use(project, "project"),
                soci::use(paused, "paused"),
                soci::use(queue.max_running, "limit"),
                soci::use(queue.keep_results, "keep"));
    });
    return queue;
}

}  // namespace divemesh::storage
