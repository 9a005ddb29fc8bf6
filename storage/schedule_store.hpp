#pragma once

#include <functional>
#include <string>

#include "schemas/schedule.hpp"
#include "storage/catalog.hpp"
#include "storage/page.hpp"

namespace divemesh::storage {

// Scheduled reports, by the catalog's clock.
class ScheduleStore {
public:
    explicit ScheduleStore(Catalog& catalog) : catalog_(catalog) {}

    // Creates a schedule and sets its id and times. Throws Error{InvalidArgument} for an invalid
    // cron expression, Error{TooMany}.
    Schedule create(const Schedule& wanted);
    // Project "": all schedules. Oldest first.
    Page<Schedule> list(const std::string& project, const PageRequest& page);
    Schedule get(const std::string& id);  // throws Error{NotFound}
    void remove(const std::string& id);   // throws Error{NotFound}

    // Creates the reports of every due schedule and returns their number. Each schedule is one
    // transaction with its next time, so that a tick runs once, whichever process finds it; missed
    // ticks are run as one. `version` is that of this program, see NewJob::fresh_version. `note` is
    // called in the transaction of each schedule that created reports. A project that stores more
    // than `max_project_bytes` (0: no limit) gets none; Schedule::last_problem says so.
    using Note = std::function<void(soci::session&, const Schedule&, int num_jobs)>;
    int run_due(const std::string& version,
                const Note& note = {},
                std::int64_t max_project_bytes = 0);

private:
    Catalog& catalog_;
};

}  // namespace divemesh::storage
