#pragma once

#include <limits>
#include <map>
#include <optional>
#include <soci/soci.h>
#include <string>
#include <vector>

#include "schemas/job.hpp"
#include "schemas/measurement.hpp"
#include "storage/catalog.hpp"
#include "storage/page.hpp"

namespace divemesh::storage {

struct MetricFilter {
    std::string metric;   // its full name
    std::string project;  // "": all projects (admin)
    std::string dive_id;  // "": any, as below
    std::string site;
    std::string rig;
    std::string tag;
    std::optional<JobKind> kind;
    std::int64_t since_ms = 0;
};

// A metric's name, unit and method.
struct MetricName {
    std::string name;
    std::string unit;
    std::string method;
};

// The metrics of all jobs that succeeded, as series over dives and time.
class MetricStore {
public:
    explicit MetricStore(Catalog& catalog) : catalog_(catalog) {}

    // Returns a page of the series, oldest first.
    Page<MetricPoint> series(const MetricFilter& filter, const PageRequest& page);
    std::optional<MetricName> find(const std::string& name);  // nullopt: no job has measured it

private:
    Catalog& catalog_;
};

// Writes what a job measured. Skips invalid metrics (a name or unit that is too long, a value that
// is not finite, too many of them), because a malicious recording may have taken over the process
// that measured.
void insert_metrics(soci::session& session, const Job& job, const Measurement& measured);

// Which earlier values a report is compared with: those of reports on earlier reconstructions by
// the same preset, of the same dive, or of all dives with `tag`. Of several reports on one
// reconstruction the newest counts.
struct MetricSeries {
    std::string project;
    std::string dive_id;
    std::string tag;  // "": of the same dive only
    std::string preset;
    std::string measured_job_id;  // excluded
};

// Returns the newest values of each metric, oldest first: of the dive itself if there are at least
// kMinEarlier, otherwise of the tag.
inline constexpr std::size_t kMinEarlier = 5;
std::map<std::string, std::vector<double>> earlier_metrics(soci::session& session,
                                                           const MetricSeries& series);

}  // namespace divemesh::storage
