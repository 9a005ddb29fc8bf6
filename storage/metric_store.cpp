#include "storage/metric_store.hpp"

#include <cmath>
#include <set>

#include "schemas/error.hpp"
#include "storage/dive_rows.hpp"
#include "storage/page_cursor.hpp"
#include "storage/sql.hpp"

namespace divemesh::storage {
namespace {

constexpr std::size_t kMaxMetrics = 5000;  // per job
constexpr std::size_t kMaxNameBytes = 300;
constexpr std::size_t kMaxUnitBytes = 32;
constexpr std::size_t kMaxMethodBytes = 1000;
constexpr int kMaxEarlier = 50;

struct NameRow {
    MetricName name;
    void define(soci::statement& statement) {
        define_columns(statement, name.name, name.unit, name.method);
    }
    MetricName value() const { return name; }
};

struct PointRow {
    MetricPoint point;

    void define(soci::statement& statement) {
        define_columns(statement,
                       point.number,
                       point.dive_id,
                       point.job_id,
                       point.kind,
                       point.site,
                       point.rig,
                       point.preset,
                       point.version,
                       point.calibration_sha256,
                       point.time_ms,
                       point.value);
    }
    MetricPoint value() const { return point; }
};

struct EarlierValue {
    std::string name;
    double value = 0.0;
};

struct EarlierRow {
    EarlierValue earlier;
    void define(soci::statement& statement) {
        define_columns(statement, earlier.name, earlier.value);
    }
    EarlierValue value() const { return earlier; }
};

bool is_metric(const MeasuredMetric& metric) {
    return !metric.name.empty() && metric.name.size() <= kMaxNameBytes &&
           metric.unit.size() <= kMaxUnitBytes && std::isfinite(metric.value);
}

std::int64_t insert_set(soci::session& session, const Job& job, const Measurement& measured) {
    const Dive dive = read_dive(session, job.dive_id);
    const std::string kind(to_string(job.kind));
    const std::string measured_job =
        job.kind == JobKind::Reconstruct ? job.id : job.options.value("job", job.id);
    const std::int64_t now_ms = Catalog::now_ms(session);
    const auto number = select_one<NumberRow>(
        session,
        "INSERT INTO metric_sets (job_id, measured_job_id, project, dive_id, kind, site, rig,"
        " preset, version, calibration_sha256, time_ms)"
        " VALUES (:job, :measured, :project, :dive, :kind, :site, :rig, :preset, :version,"
        " :calibration, :now) RETURNING number",
        soci::use(job.id, "job"),
        soci::use(measured_job, "measured"),
        soci::use(job.project, "project"),
        soci::use(job.dive_id, "dive"),
        soci::use(kind, "kind"),
        soci::use(dive.site, "site"),
        soci::use(dive.rig, "rig"),
        soci::use(job.preset, "preset"),
        soci::use(measured.version, "version"),
        soci::use(measured.calibration_sha256, "calibration"),
        soci::use(now_ms, "now"));
    return number.value();
}

std::int64_t number_of_name(soci::session& session, const MeasuredMetric& metric) {
    const std::string method = metric.method.substr(0, kMaxMethodBytes);
    const auto number = select_one<NumberRow>(
        session,
        "INSERT INTO metric_names (name, unit, method) VALUES (:name, :unit, :method)"
        " ON CONFLICT (name) DO UPDATE SET unit = excluded.unit, method = excluded.method"
        " RETURNING number",
        soci::use(metric.name, "name"),
        soci::use(metric.unit, "unit"),
        soci::use(method, "method"));
    return number.value();
}

// Returns one condition of a series. Without a value the statement does not contain it, so that the
// planner sees which index fits. The name appears in any case, because SOCI binds all of them.
std::string narrowed(const std::string& value, const std::string& condition, const char* name) {
    return value.empty() ? std::string(" AND :") + name + " = ''" : " AND " + condition;
}

using Earlier = std::map<std::string, std::vector<double>>;

// Returns the values of the newest report on each of the newest reconstructions.
Earlier earlier_of(soci::session& session, const MetricSeries& series, const std::string& whose) {
    Earlier earlier;
    const auto rows = select_all<EarlierRow>(
        session,
        "SELECT name, value FROM (SELECT MAX(number) AS newest FROM metric_sets"
        "   WHERE kind = 'accuracy_report' AND project = :project AND preset = :preset"
        "   AND measured_job_id <> :measured AND " +
            whose +
            "   GROUP BY measured_job_id ORDER BY newest DESC LIMIT :limit) AS sets"
            " CROSS JOIN metric_names"
            " JOIN metric_values ON metric = metric_names.number AND set_number = newest"
            " ORDER BY newest",
        soci::use(series.project, "project"),
        soci::use(series.preset, "preset"),
        soci::use(series.measured_job_id, "measured"),
        soci::use(series.dive_id, "dive"),
        soci::use(series.tag, "tag"),
        soci::use(kMaxEarlier, "limit"));
    for (const EarlierValue& row : rows) earlier[row.name].push_back(row.value);
    return earlier;
}

}  // namespace

Page<MetricPoint> MetricStore::series(const MetricFilter& filter, const PageRequest& page) {
    const PageStart start = page_start(page);
    const std::string kind = filter.kind ? std::string(to_string(*filter.kind)) : "";
    const std::string sql =
        "SELECT sets.number, sets.dive_id, job_id, kind, site, rig, preset, version,"
        " calibration_sha256, time_ms, value FROM metric_values"
        " JOIN metric_sets AS sets ON sets.number = set_number"
        " WHERE metric = (SELECT number FROM metric_names WHERE name = :metric)"
        " AND set_number > :after AND time_ms >= :since" +
        narrowed(filter.project, "project = :project", "project") +
        narrowed(filter.dive_id,
                 "set_number IN (SELECT number FROM metric_sets WHERE dive_id = :dive)",
                 "dive") +
        narrowed(filter.site, "site = :site", "site") + narrowed(filter.rig, "rig = :rig", "rig") +
        narrowed(
            filter.tag, "sets.dive_id IN (SELECT dive_id FROM dive_tags WHERE tag = :tag)", "tag") +
        narrowed(kind, "kind = :kind", "kind") + " ORDER BY set_number LIMIT :limit";
    std::vector<MetricPoint> points;
    catalog_.read([&](soci::session& session) {
        points = select_all<PointRow>(session,
                                      sql,
                                      soci::use(filter.metric, "metric"),
                                      soci::use(start.created_at_ms, "after"),
                                      soci::use(filter.since_ms, "since"),
                                      soci::use(filter.project, "project"),
                                      soci::use(filter.dive_id, "dive"),
                                      soci::use(filter.site, "site"),
                                      soci::use(filter.rig, "rig"),
                                      soci::use(filter.tag, "tag"),
                                      soci::use(kind, "kind"),
                                      soci::use(start.limit_plus_one, "limit"));
    });
    Page<MetricPoint> result{.items = std::move(points)};
    const auto limit = static_cast<std::size_t>(page.limit);
    if (result.items.size() <= limit) return result;
    result.items.resize(limit);
    result.next_cursor = cursor_after(result.items.back().number, result.items.back().job_id);
    return result;
}

std::optional<MetricName> MetricStore::find(const std::string& name) {
    std::optional<MetricName> found;
    catalog_.read([&](soci::session& session) {
        found =
            select_one<NameRow>(session,
                                "SELECT name, unit, method FROM metric_names WHERE name = :name",
                                soci::use(name, "name"));
    });
    return found;
}

void insert_metrics(soci::session& session, const Job& job, const Measurement& measured) {
    if (measured.metrics.empty()) return;
    const std::int64_t set_number = insert_set(session, job, measured);
    std::set<std::string> seen;
    for (const MeasuredMetric& metric : measured.metrics) {
        if (!is_metric(metric) || seen.size() == kMaxMetrics || !seen.insert(metric.name).second)
            continue;
        const std::int64_t number = number_of_name(session, metric);
        execute(
            session,
            "INSERT INTO metric_values (metric, set_number, value) VALUES (:metric, :set, :value)",
            soci::use(number, "metric"),
            soci::use(set_number, "set"),
            soci::use(metric.value, "value"));
    }
}

Earlier earlier_metrics(soci::session& session, const MetricSeries& series) {
    Earlier earlier = earlier_of(session, series, "dive_id = :dive AND :tag = :tag");
    if (series.tag.empty()) return earlier;
    const Earlier of_tag =
        earlier_of(session,
                   series,
                   ":dive = :dive AND dive_id IN (SELECT dive_id FROM dive_tags WHERE tag = :tag)");
    for (const auto& [name, values] : of_tag) {
        std::vector<double>& own = earlier[name];
        if (own.size() < kMinEarlier) own = values;
    }
    return earlier;
}

}  // namespace divemesh::storage
