#include "storage/schedule_store.hpp"

#include "schemas/cron.hpp"
#include "schemas/error.hpp"
#include "storage/ids.hpp"
#include "storage/job_changes.hpp"
#include "storage/page_cursor.hpp"
#include "storage/project_usage.hpp"
#include "storage/sql.hpp"

namespace divemesh::storage {
namespace {

constexpr std::int64_t kMaxSchedulesOfProject = 100;
constexpr int kMaxJobsOfRun = 1000;

const std::string kSelect =
    "SELECT id, project, cron, tag, preset, options, created_at_ms, next_run_ms, last_run_ms,"
    " last_num_jobs, last_problem FROM schedules WHERE ";

struct ScheduleRow {
    Schedule schedule;
    std::string options;

    void define(soci::statement& statement) {
        define_columns(statement,
                       schedule.id,
                       schedule.project,
                       schedule.cron,
                       schedule.tag,
                       schedule.preset,
                       options,
                       schedule.created_at_ms,
                       schedule.next_run_ms,
                       schedule.last_run_ms,
                       schedule.last_num_jobs,
                       schedule.last_problem);
    }
    Schedule value() const {
        Schedule value = schedule;
        value.options = nlohmann::json::parse(options);
        return value;
    }
};

Schedule read_schedule(soci::session& session, const std::string& id) {
    auto schedule = select_one<ScheduleRow>(session, kSelect + "id = :id", soci::use(id, "id"));
    if (!schedule) throw Error(ErrorCode::NotFound, "no schedule " + id);
    return std::move(*schedule);
}

void require_few(soci::session& session, const std::string& project) {
    std::int64_t count = 0;
    session << "SELECT COUNT(*) FROM schedules WHERE project = :project", soci::into(count),
        soci::use(project, "project");
    if (count >= kMaxSchedulesOfProject)
        throw Error(ErrorCode::TooMany,
                    "project " + project + " has " + std::to_string(kMaxSchedulesOfProject) +
                        " schedules: delete some");
}

std::vector<std::string> dives_with_tag(soci::session& session, const Schedule& schedule) {
    const int limit = kMaxJobsOfRun + 1;
    return select_all<TextRow>(
        session,
        "SELECT id FROM dives WHERE project = :project AND state = 'ready' AND deleted_at_ms = 0"
        " AND id IN (SELECT dive_id FROM dive_tags WHERE tag = :tag)"
        " ORDER BY created_at_ms DESC, id DESC LIMIT :limit",
        soci::use(schedule.project, "project"),
        soci::use(schedule.tag, "tag"),
        soci::use(limit, "limit"));
}

// Returns false if another process was first, or the schedule is gone.
bool take_tick(soci::session& session, const Schedule& schedule, std::int64_t now_ms) {
    const std::int64_t next_ms = Cron::parse(schedule.cron).next_after_ms(now_ms);
    return execute(session,
                   "UPDATE schedules SET next_run_ms = :next, last_run_ms = :now"
                   " WHERE id = :id AND next_run_ms = :due",
                   soci::use(next_ms, "next"),
                   soci::use(now_ms, "now"),
                   soci::use(schedule.id, "id"),
                   soci::use(schedule.next_run_ms, "due")) == 1;
}

NewJob report_of(const Schedule& schedule, const std::string& dive_id, const std::string& version) {
    NewJob job{.project = schedule.project,
               .dive_id = dive_id,
               .kind = JobKind::AccuracyReport,
               .preset = schedule.preset,
               .options = schedule.options};
    job.options["tag"] = schedule.tag;
    if (schedule.options.value("fresh", true)) job.fresh_version = version;
    job.options.erase("fresh");
    return job;
}

// Leaves out the dives that get no report and returns why; "" if all get one.
std::string limit_dives(soci::session& session,
                        const Schedule& schedule,
                        std::int64_t max_project_bytes,
                        std::vector<std::string>& dives) {
    if (dives.empty()) return "no dive has this tag";
    try {
        require_bytes_of_quota(session, schedule.project, 0, max_project_bytes);
    } catch (const Error& error) {
        if (error.code() != ErrorCode::OutOfQuota) throw;
        dives.clear();
        return error.what();
    }
    if (dives.size() <= kMaxJobsOfRun) return "";
    dives.resize(kMaxJobsOfRun);
    return "too many dives have this tag, only the newest " + std::to_string(kMaxJobsOfRun) +
           " are used";
}

int make_reports(soci::session& session,
                 const Schedule& schedule,
                 const std::string& version,
                 std::int64_t max_project_bytes) {
    auto dives = dives_with_tag(session, schedule);
    std::string problem = limit_dives(session, schedule, max_project_bytes, dives);
    int num_jobs = 0;
    for (const std::string& dive : dives) {
        try {
            num_jobs += enqueue_job(session, report_of(schedule, dive, version)).is_new ? 1 : 0;
        } catch (const Error& error) {
            if (error.code() == ErrorCode::Unavailable) throw;
            problem = "dive " + dive + ": " + error.what();
        }
    }
    execute(session,
            "UPDATE schedules SET last_num_jobs = :jobs, last_problem = :problem WHERE id = :id",
            soci::use(num_jobs, "jobs"),
            soci::use(problem, "problem"),
            soci::use(schedule.id, "id"));
    return num_jobs;
}

}  // namespace

Schedule ScheduleStore::create(const Schedule& wanted) {
    Schedule schedule = wanted;
    const Cron cron = Cron::parse(schedule.cron);
    const std::string options = to_text(schedule.options);
    catalog_.transaction([&](soci::session& session) {
        require_few(session, schedule.project);
        schedule.id = new_id("schedule");
        schedule.created_at_ms = Catalog::now_ms(session);
        schedule.next_run_ms = cron.next_after_ms(schedule.created_at_ms);
        execute(session,
                "INSERT INTO schedules (id, project, cron, tag, preset, options, created_at_ms,"
                " next_run_ms)"
                " VALUES (:id, :project, :cron, :tag, :preset, :options, :now, :next)",
                soci::use(schedule.id, "id"),
                soci::use(schedule.project, "project"),
                soci::use(schedule.cron, "cron"),
                soci::use(schedule.tag, "tag"),
                soci::use(schedule.preset, "preset"),
                soci::use(options, "options"),
                soci::use(schedule.created_at_ms, "now"),
                soci::use(schedule.next_run_ms, "next"));
    });
    return schedule;
}

Page<Schedule> ScheduleStore::list(const std::string& project, const PageRequest& page) {
    const PageStart start = page_start(page);
    std::vector<Schedule> rows;
    catalog_.read([&](soci::session& session) {
        rows = select_all<ScheduleRow>(
            session,
            kSelect +
                "(:project = '' OR project = :project)"
                " AND (created_at_ms > :age OR (created_at_ms = :age AND id > :id))"
                " ORDER BY created_at_ms, id LIMIT :limit",
            soci::use(project, "project"),
            soci::use(start.created_at_ms, "age"),
            soci::use(start.id, "id"),
            soci::use(start.limit_plus_one, "limit"));
    });
    return make_page(std::move(rows), page);
}

Schedule ScheduleStore::get(const std::string& id) {
    Schedule schedule;
    catalog_.read([&](soci::session& session) { schedule = read_schedule(session, id); });
    return schedule;
}

void ScheduleStore::remove(const std::string& id) {
    catalog_.transaction([&](soci::session& session) {
        read_schedule(session, id);
        execute(session, "DELETE FROM schedules WHERE id = :id", soci::use(id, "id"));
    });
}

// A schedule whose last run is in the future ran before the clock was set back: its next time is
// computed again, without a run.
int ScheduleStore::run_due(const std::string& version,
                           const Note& note,
                           std::int64_t max_project_bytes) {
    std::vector<Schedule> due;
    catalog_.read([&](soci::session& session) {
        const std::int64_t now_ms = Catalog::now_ms(session);
        due = select_all<ScheduleRow>(session,
                                      kSelect +
                                          "next_run_ms <= :now OR last_run_ms > :now"
                                          " ORDER BY next_run_ms, id",
                                      soci::use(now_ms, "now"));
    });
    int num_jobs = 0;
    for (const Schedule& schedule : due)
        catalog_.transaction([&](soci::session& session) {
            const std::int64_t now_ms = Catalog::now_ms(session);
            if (!take_tick(session, schedule, now_ms) || schedule.next_run_ms > now_ms) return;
            const int num_made = make_reports(session, schedule, version, max_project_bytes);
            if (note && num_made > 0) note(session, schedule, num_made);
            num_jobs += num_made;
        });
    return num_jobs;
}

}  // namespace divemesh::storage
