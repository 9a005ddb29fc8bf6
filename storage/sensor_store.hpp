#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <vector>

#include "schemas/error.hpp"
#include "schemas/sensor.hpp"
#include "schemas/sensor_message.hpp"
#include "storage/catalog.hpp"
#include "storage/page.hpp"
#include "storage/preview_store.hpp"

namespace divemesh::storage {

// A report of a device, with the sensor and project that it is for.
struct IncomingReport {
    std::string sensor;
    std::string project;
    SensorReport report;
};

// An answer, or the reason why there is none. A failure does not affect other reports of the same
// transaction.
struct ReportOutcome {
    SensorAnswer answer;
    std::optional<Error> failure;
    Sensor sensor;  // after the report, current; unset on failure
};

// Devices in the field: their last report, which messages were received, and their alarms.
class SensorStore {
public:
    explicit SensorStore(Catalog& catalog) : catalog_(catalog) {}

    // Takes the reports in one transaction, in their order, and returns one outcome each. Creates
    // an unknown sensor. A repeated message changes nothing. Errors of an outcome: Conflict (the id
    // belongs to another project). Keeps `max_previews` previews of a sensor.
    std::vector<ReportOutcome> receive(const std::vector<IncomingReport>& reports,
                                       int max_previews = kMaxPreviews);

    // Throws Error{NotFound}.
    Sensor get(const std::string& id);
    // Returns sensors in the order in which they were first heard of; project "": all.
    Page<Sensor> list(const std::string& project, const PageRequest& page);

    // Updates what only time changes and writes the events: changed states, overdue sensors, late
    // commands. Writes nothing without such a change. Returns the changed sensors.
    std::vector<Sensor> look_at_the_time();
    // Forgets some of the statuses older than `age`; returns false if there are more.
    bool forget_older_than(std::chrono::milliseconds age);

private:
    Catalog& catalog_;
};

}  // namespace divemesh::storage
