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

// What a device sent, and in whose name.
struct IncomingReport {
    std::string sensor;
    std::string project;
    SensorReport report;
};

// An answer, or why there is none; the others of the same transaction are not touched by it.
struct ReportOutcome {
    SensorAnswer answer;
    std::optional<Error> failure;
    Sensor sensor;  // after it, as of now; without a failure
};

// Devices in the field: what they last said, what of it has come, what is wrong with them.
class SensorStore {
public:
    explicit SensorStore(Catalog& catalog) : catalog_(catalog) {}

    // Takes the reports in one transaction, in their order; one outcome each. A sensor that is not
    // known comes into being. A message that came before changes nothing. Errors of an outcome:
    // Conflict (the id is another project's). Of the previews of a sensor so many are kept.
    std::vector<ReportOutcome> receive(const std::vector<IncomingReport>& reports,
                                       int max_previews = kMaxPreviews);

    // Throws Error{NotFound}.
    Sensor get(const std::string& id);
    // In the order they were first heard of; project "": all.
    Page<Sensor> list(const std::string& project, const PageRequest& page);

    // What changes by the time alone: tells whose state is another now, who is overdue, and which
    // commands came too late. Writes nothing when there is nothing to tell. Those that are others.
    std::vector<Sensor> look_at_the_time();
    // Statuses older than that, some at a time; false: there are more.
    bool forget_older_than(std::chrono::milliseconds age);

private:
    Catalog& catalog_;
};

}  // namespace divemesh::storage
