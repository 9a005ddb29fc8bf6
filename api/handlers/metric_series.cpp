#include "api/handlers/metric_series.hpp"

#include "api/authorization.hpp"
#include "api/handlers/json_body.hpp"
#include "api/handlers/resource.hpp"
#include "api/in_pool.hpp"
#include "schemas/json.hpp"
#include "schemas/metric.hpp"
#include "storage/metric_store.hpp"

namespace divemesh::api {
namespace {

storage::MetricFilter filter_of(const Request& request) {
    const std::string metric_name = query_value(request, "metric");
    if (metric_name.empty())
        throw InvalidInput(
            {{"metric is missing: give the name of a metric, e.g. drift_percent", "", "metric"}});
    storage::MetricFilter filter{.metric = resolve_metric(metric_name),
                                 .project = visible_project(request.token),
                                 .dive_id = query_value(request, "dive_id"),
                                 .site = query_value(request, "site"),
                                 .rig = query_value(request, "rig"),
                                 .tag = query_value(request, "tag"),
                                 .since_ms = time_value(request, "since", 0)};
    const std::string kind = query_value(request, "kind");
    if (!kind.empty()) filter.kind = job_kind_from_string(kind);
    return filter;
}

struct Series {
    storage::Page<MetricPoint> points;
    storage::MetricName metric;
};

}  // namespace

Awaitable<Response> get_metric_series(Request request, Services services) {
    auto work =
        [&catalog = services.catalog, filter = filter_of(request), page = page_request(request)] {
            storage::MetricStore store(catalog);
            return Series{store.series(filter, page),
                          store.find(filter.metric).value_or(storage::MetricName{filter.metric})};
        };
    const Series series = co_await in_pool(services.pool, std::move(work));
    nlohmann::json items = nlohmann::json::array();
    const auto choice = FieldChoice::of<MetricPoint>(request);
    for (const MetricPoint& point : series.points.items) items.push_back(choice.leave(point));
    nlohmann::json about = {{"metric", series.metric.name},
                            {"unit", series.metric.unit},
                            {"method", series.metric.method}};
    co_return page_response(request, std::move(items), series.points.next_cursor, about);
}

Awaitable<Response> list_metrics(Request request, Services services) {
    auto read = [](const Request&, storage::Catalog&) { return known_metrics(); };
    return get_list(std::move(request), services, read);
}

}  // namespace divemesh::api
