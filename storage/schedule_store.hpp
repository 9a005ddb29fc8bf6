#pragma once

#include <functional>
#include <string>

#include "schemas/schedule.hpp"
#include "storage/catalog.hpp"
#include "storage/page.hpp"

namespace divemesh::storage {

// Reports by the clock: the catalog's alone.
class ScheduleStore {
public:
    explicit ScheduleStore(Catalog& catalog) : catalog_(catalog) {}

    // Id and times are set here. Throws Error{InvalidArgument} for a cron expression that is none,
    // Error{TooMany}.
    Schedule create(const Schedule& wanted);
    // Project "": of all. Oldest first.
    Page<Schedule> list(const std::string& project, const PageRequest& page);
    Schedule get(const std::string& id);  // throws Error{NotFound}
    void remove(const std::string& id);   // the same

    // Makes the reports of every schedule that is due, each in one transaction with its next time,
    // so that a tick is run once whoever looks, and those that nobody looked at are run as one.
    // `version` is that of this program, see NewJob::fresh_version. How many jobs it made; of each
    // schedule that made some, `note` is told in its transaction.
    using Note = std::function<void(soci::session&, const Schedule&, int num_jobs)>;
    int run_due(const std::string& version, const Note& note = {});

private:
    Catalog& catalog_;
};

}  // namespace divemesh::storage
